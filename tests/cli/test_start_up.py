"""`robotid --help` answers at once because it imports next to nothing."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

HEAVY = {"numpy", "scipy", "h5py", "pydantic", "yaml", "matplotlib", "jinja2"}
SCRIPT = """
import json, sys
from robotid.cli.app import main
code = main(sys.argv[1:])
print(json.dumps([code, sorted({name.partition(".")[0] for name in sys.modules})]), file=sys.stderr)
"""
MODULES = """
import json, sys
from robotid.cli.app import main
code = main(sys.argv[1:])
print(json.dumps([code, sorted(sys.modules)]), file=sys.stderr)
"""
SLOW = {f"scipy.{part}" for part in ("integrate", "linalg", "optimize", "signal", "stats")} | {"matplotlib", "jinja2"}
"""What only those need who compute or draw; scipy itself is there for its version."""


@pytest.mark.parametrize(
    ("arguments", "allowed"),
    [
        (["--help"], set()),
        (["--version"], set()),
        (["fit", "--help"], {"pydantic"}),  # typer's own, to read options
        (["run", "--help"], {"pydantic"}),
    ],
)
def test_help_imports_nothing_heavy(arguments: list[str], allowed: set[str]) -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT, *arguments], capture_output=True, text=True, check=True)
    code, modules = json.loads(done.stderr)
    assert code == 0
    assert "typer" in modules
    assert HEAVY & set(modules) <= allowed


@pytest.mark.parametrize("command", ["status", "run"])
def test_a_command_without_work_imports_nothing_that_works(command: str, finished: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", MODULES, command, finished], capture_output=True, text=True, check=True
    )
    code, modules = json.loads(done.stderr.splitlines()[-1])
    assert code == 0
    assert "h5py" in modules
    assert not SLOW & set(modules)
