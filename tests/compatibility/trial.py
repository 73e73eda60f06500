"""What must work in an environment: the command answers, and records become a report with the right verdict."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from pathlib import Path

from compatibility.environment import Environment

CONFIGURATIONS = ("smoke", "demo")  # a virtual robot, and measured files; on both the model is complete
MOST = 600.0  # [s] for one command
# Deprecations that our own lines cause are errors: what is announced today fails with the next version.
STRICT = """
import sys, warnings
from robotid.cli.app import main
warnings.filterwarnings("error", module=r"robotid(\\.|$)")
sys.exit(main())
"""


class TrialError(Exception):
    """Something that must work in this environment does not."""


def try_out(environment: Environment, configs: Path) -> dict[str, float]:
    """Seconds [s] that each configuration took. Raises TrialError, with what the failing command wrote last."""
    for words in (["--help"], ["run", "--help"], ["--version"], ["explain", "coulomb"]):
        _run(environment, [str(environment.scripts / "robotid"), *words])
    return {name: _identify(environment, configs / f"{name}.yaml") for name in CONFIGURATIONS}


def _identify(environment: Environment, config: Path) -> float:
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        words = ["run", str(config), "--out", folder, "--json", "--jobs", "1"]
        found = json.loads(_run(environment, [str(environment.python), "-c", STRICT, *words]))
        verdict = found["diagnose"]["verdict"]
        if verdict != "clean":
            raise TrialError(f"{config.stem}: the verdict is {verdict!r}, which should be 'clean'")
        if not (Path(folder) / "report.html").is_file():
            raise TrialError(f"{config.stem}: no report was written")
    return time.monotonic() - begin


def _run(environment: Environment, command: list[str]) -> str:
    """Standard output of a command in a folder of its own, so that nothing but the installed package is imported."""
    quiet = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with tempfile.TemporaryDirectory() as here:
        threads = {"OPENBLAS_NUM_THREADS": "1", "ROBOTID_CACHE": str(Path(here) / "cache")}
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, check=False, cwd=here, env=quiet | threads, timeout=MOST
            )
        except subprocess.TimeoutExpired:
            raise TrialError(f"{_words(environment, command)}: no end after {MOST:g} s") from None
    if done.returncode != 0:
        last = " | ".join(done.stderr.splitlines()[-3:])
        raise TrialError(f"{_words(environment, command)}: exit code {done.returncode}: {last}")
    return done.stdout


def _words(environment: Environment, command: list[str]) -> str:
    return " ".join(["robotid", *(word for word in command[1:] if word not in ("-c", STRICT))])
