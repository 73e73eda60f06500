"""Where the process begins: signals are taken care of before anything heavy is imported."""

from __future__ import annotations

import sys
import warnings

from robotid.interrupt import interruptible


def main() -> int:
    """Run the process's own command line and return its exit code."""
    if not sys.warnoptions:
        # what a library remarks on is no message to whoever types a command; python -W shows it
        warnings.simplefilter("ignore")
    with interruptible(last=True):
        from robotid.cli.app import main

        return main()
