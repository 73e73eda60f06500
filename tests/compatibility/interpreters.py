"""Which interpreters a machine has: on the path, and where version managers put theirs."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

OLDEST = (3, 11)
NEWEST_SOUGHT = 20  # minor version; later ones are found as plain python3
ASK = (
    "import json, sys; print(json.dumps([sys.version_info[:3], getattr(sys, '_base_executable', sys.executable),"
    " sys.version_info.releaselevel, sys.implementation.name]))"
)


@dataclass(frozen=True, slots=True)
class Interpreter:
    """A Python of this machine: its three numbers and its executable, that of no virtual environment."""

    numbers: tuple[int, int, int]
    path: str

    @property
    def version(self) -> str:
        return ".".join(map(str, self.numbers))

    @property
    def minor(self) -> str:
        return "{}.{}".format(*self.numbers)


def find_interpreters(names: Sequence[str] | None = None) -> list[Interpreter]:
    """The latest patch of every CPython release of 3.11 and newer, oldest first; names : these and no others."""
    latest: dict[tuple[int, int], Interpreter] = {}
    for path in names or _candidates():
        one = _ask(path)
        if one is None or one.numbers < OLDEST:
            continue
        known = latest.get(one.numbers[:2])
        if known is None or one.numbers > known.numbers:
            latest[one.numbers[:2]] = one
    return [latest[minor] for minor in sorted(latest)]


def _candidates() -> Iterator[str]:
    names = ["python3", "python", *(f"python3.{minor}" for minor in range(OLDEST[1], NEWEST_SOUGHT))]
    for folder in os.get_exec_path():
        yield from (path for name in names if (path := shutil.which(name, path=folder)) is not None)
    home = Path.home()
    managed = (Path(os.environ.get("PYENV_ROOT", home / ".pyenv")) / "versions", home / ".local/share/uv/python")
    for versions in managed:
        yield from (str(path) for path in sorted(versions.glob("*/bin/python3")))


def _ask(path: str) -> Interpreter | None:
    """An interpreter by its own account; None where nothing answers, and for pre-releases and other implementations."""
    try:
        done = subprocess.run([path, "-c", ASK], capture_output=True, text=True, check=True, timeout=60)
        numbers, executable, level, name = json.loads(done.stdout)
    except (OSError, ValueError, subprocess.SubprocessError):
        return None
    if level != "final" or name != "cpython":
        return None
    return Interpreter(tuple(numbers), executable or path)
