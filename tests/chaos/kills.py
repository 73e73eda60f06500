"""A run that is stopped at a random moment leaves a run directory that is whole, and the next run completes it."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from support.paths import ROOT

from robotid.artifacts.store import load
from robotid.errors import InputError
from robotid.pipeline.lock import LOCK
from robotid.pipeline.table import STAGES

SMALL = """\
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - name: slow
    excite: {kind: triangle, amplitude: 20, period: 2, sampling_time: 0.005}
plant:
  parameters: {motor.inertia.J: 0.01, motor.viscous.Fv: 0.02, motor.coulomb.Fc: 0.5}
  controller: {kind: speed, kp: 0.5, ki: 5}
  noise: {speed: 0.01}
diagnose: {max_causes: 1, max_refits: 1}
"""
"""A configuration whose stages all do something, and whose run takes hardly longer than its imports."""
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
PATIENCE = 120.0  # [s] for any command


@dataclass(frozen=True, slots=True)
class Kill:
    """What became of a run that got a signal after some seconds. code : of the process; wrong : what did not hold."""

    number: signal.Signals
    after: float
    code: int
    wrong: tuple[str, ...]


def configuration(folder: Path) -> Path:
    """The small configuration as a file in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "axis.yaml"
    file.write_text(SMALL)
    return file


def robotid(*arguments: str) -> subprocess.Popen[bytes]:
    """A command of robotid, in a process."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "robotid", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)


def kill(config: Path, folder: Path, number: signal.Signals, after: float) -> Kill:
    """Start a run of a configuration in a folder, send it a signal, and examine what is left."""
    before = _remains(folder)  # of a run that was killed: this one may end before it comes to remove them
    began = time.monotonic()
    process = robotid("run", str(config), "--out", str(folder), "--quiet")
    try:
        process.wait(after)
    except subprocess.TimeoutExpired:
        process.send_signal(number)
    _, err = process.communicate(timeout=PATIENCE)
    wrong = [*_wrong_end(number, process.returncode, err), *damage(folder)]
    if number is not signal.SIGKILL:
        wrong += [f"{name} is left" for name in sorted(_remains(folder) - before)]
    return Kill(number, time.monotonic() - began, process.returncode, tuple(wrong))


def _remains(folder: Path) -> set[str]:
    """Names in a folder that a run leaves there only while it works."""
    names = os.listdir(folder) if folder.exists() else []
    return {name for name in names if name.endswith(".part") or name == LOCK}


def _wrong_end(number: signal.Signals, code: int, err: bytes) -> list[str]:
    allowed = {0, -signal.SIGKILL} if number is signal.SIGKILL else {0, 130}
    wrong = [f"exit code {code}"] if code not in allowed else []
    if b"Traceback" in err or err.count(b"\n") > 1:
        wrong.append(f"stderr is {err.decode(errors='replace')}")
    return wrong


def damage(folder: Path) -> list[str]:
    """Artifacts that are there and do not load."""
    wrong = []
    for stage in STAGES.values():
        if (folder / stage.output).exists():
            try:
                load(folder / stage.output, stage.type())
            except InputError as error:
                wrong.append(str(error))
    return wrong


def completion(config: Path, folder: Path) -> list[str]:
    """What is wrong with `status`, with the next run, or with what that leaves."""
    wrong = []
    for arguments in (["status", str(config), "--json"], ["run", str(config), "--quiet"]):
        process = robotid(*arguments, "--out", str(folder))
        _, err = process.communicate(timeout=PATIENCE)
        if process.returncode or err:
            wrong.append(f"{arguments[0]} ends with {process.returncode}: {err.decode(errors='replace')}")
    wrong += [f"{stage.output} is absent" for stage in STAGES.values() if not (folder / stage.output).exists()]
    wrong += [f"{name} is left" for name in os.listdir(folder) if name.startswith(".")]
    return wrong + damage(folder)


def duration(config: Path, folder: Path) -> float:
    """Seconds that a whole run takes here."""
    began = time.monotonic()
    process = robotid("run", str(config), "--out", str(folder), "--quiet")
    process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    return time.monotonic() - began


def moment(rng: random.Random, whole: float) -> tuple[signal.Signals, float]:
    """Which signal, and when: the first second, in which all is imported, gets its share."""
    return rng.choice(SIGNALS), rng.uniform(0.15, whole)
