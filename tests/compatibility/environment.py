"""An environment for one Python and one end of the versions: made once, used again while nothing has changed."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import time
import tomllib
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from compatibility.interpreters import Interpreter

WEEK = 7 * 24 * 3600.0  # [s] after which the newest versions are looked for again
BOUND = re.compile(r"^([\w.-]+)>=([\w.]+)((?:\s*;.*)?)$")
SHOWN = ("numpy", "scipy", "h5py", "pydantic", "typer", "rich", "matplotlib", "pyyaml", "jinja2")


class Side(StrEnum):
    """The two ends of what pyproject.toml allows."""

    LOWEST = "lowest"
    NEWEST = "newest"


class PreparationError(Exception):
    """An environment cannot be made, though it should."""


class UnsupportedError(Exception):
    """This Python is not one that robotid promises to run on, and some dependency has no wheel for it."""


@dataclass(frozen=True, slots=True)
class Environment:
    """A virtual environment with robotid in it, and the versions beside it, by name."""

    name: str
    folder: Path
    versions: dict[str, str]
    reused: bool

    @property
    def scripts(self) -> Path:
        return self.folder / ("Scripts" if os.name == "nt" else "bin")

    @property
    def python(self) -> Path:
        return self.scripts / "python"


def requirements(project: dict[str, Any], side: Side) -> list[str]:
    """The dependencies of a [project] table, as they stand or with every lower bound as the exact version.

    Raises PreparationError for a dependency without a lower bound: its lowest version is anybody's guess.
    """
    wanted: list[str] = project["dependencies"]
    if side is Side.NEWEST:
        return wanted
    bounds = [BOUND.match(one) for one in wanted]
    bare = [one for one, bound in zip(wanted, bounds, strict=True) if bound is None]
    if bare:
        raise PreparationError(f"pyproject.toml: {bare[0]!r} is not of the form name>=version")
    return [f"{bound[1]}=={bound[2]}{bound[3]}" for bound in bounds if bound is not None]


def build_wheel(root: Path, interpreter: Interpreter, folder: Path) -> Path:
    """The wheel of a checkout. Raises PreparationError."""
    built = folder / "wheel"
    shutil.rmtree(built, ignore_errors=True)
    _run([interpreter.path, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(built), str(root)])
    (wheel,) = built.glob("*.whl")
    return wheel


def prepare(root: Path, interpreter: Interpreter, side: Side, wheel: Path, folder: Path) -> Environment:
    """An environment of this side of the versions, with this wheel installed.

    Raises UnsupportedError where a Python outside the classifiers of pyproject.toml lacks wheels, PreparationError
    where anything else goes wrong.
    """
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = requirements(project, side)
    name = f"{interpreter.minor}-{side}"
    home = folder / name
    stamp = home / "made.json"
    made_from = hashlib.sha256(json.dumps([interpreter.version, interpreter.path, wanted]).encode()).hexdigest()
    reused = _is_fresh(stamp, made_from, side)
    environment = Environment(name, home, {}, reused)
    if not reused:
        shutil.rmtree(home, ignore_errors=True)
        _run([interpreter.path, "-m", "venv", str(home)])
        try:
            _pip(environment, "install", "--quiet", "--only-binary", ":all:", *wanted)
        except PreparationError as error:
            promised = f"Programming Language :: Python :: {interpreter.minor}" in project["classifiers"]
            lacking = re.search(r"No matching distribution found for (\S+)", str(error))
            if lacking is not None and not promised:
                raise UnsupportedError(f"there is no wheel of {lacking[1]} for this Python") from None
            raise
    _pip(environment, "install", "--quiet", "--no-deps", "--force-reinstall", str(wheel))
    if not reused:
        stamp.write_text(json.dumps({"from": made_from, "at": time.time()}), encoding="utf-8")
    listed = json.loads(_pip(environment, "list", "--format", "json"))
    versions = {entry["name"].lower(): entry["version"] for entry in listed}
    return Environment(name, home, {one: versions[one] for one in SHOWN}, reused)


def _is_fresh(stamp: Path, made_from: str, side: Side) -> bool:
    try:
        made = json.loads(stamp.read_text(encoding="utf-8"))
        return made["from"] == made_from and (side is Side.LOWEST or time.time() - made["at"] < WEEK)
    except (OSError, ValueError, KeyError):
        return False


def _pip(environment: Environment, *arguments: str) -> str:
    return _run([str(environment.python), "-m", "pip", "--disable-pip-version-check", *arguments])


def _run(command: list[str]) -> str:
    """Standard output of a command. Raises PreparationError with the errors that it ended in."""
    clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=clean)
    if done.returncode != 0:
        errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")] or done.stderr.splitlines()
        raise PreparationError(" ".join(errors[-3:]) or f"{command[0]} ended with code {done.returncode}")
    return done.stdout
