"""Where the process begins: signals are taken care of before anything heavy is imported."""

from __future__ import annotations

from robotid.interrupt import interruptible


def main() -> int:
    """Run the process's own command line and return its exit code."""
    with interruptible():
        from robotid.cli.app import main

        return main()
