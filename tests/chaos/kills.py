"""A run that is stopped at a random moment leaves a run directory that is whole, and the next run completes it.

Most runs are forked from a process that has imported all that a run needs: what is killed then is the run, not its
imports. The others begin as a command does.
"""

from __future__ import annotations

import contextlib
import io
import os
import random
import signal
import sys
import time
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from support.paths import ROOT

from robotid.artifacts.store import load
from robotid.cli.app import main
from robotid.errors import InputError
from robotid.interrupt import interruptible
from robotid.pipeline.check import FILE as KEPT_CHECK
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
POLL = 0.005  # [s] between two looks whether a process has ended
COLD = 5  # one kill in so many is of a process that imports all itself
IMPORTS = 2.0  # [s] by which it takes longer


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


def warm_up(config: Path, folder: Path) -> None:
    """Import all that a run needs, by a run in this process. folder : for the run directory."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        assert main(["run", str(config), "--out", str(folder), "--quiet"]) == 0


@dataclass(frozen=True, slots=True)
class Command:
    """A command of robotid in a process of its own. pid : of that; err : the file that gets its stderr."""

    pid: int
    err: Path

    @classmethod
    def start(cls, arguments: list[str], err: Path, *, cold: bool) -> Command:
        """Start one, by a fork of this process, which must have a single thread, or else from nothing. When this
        returns, a forked one takes care of its signals."""
        begins, begun = os.pipe()  # not inherited where another program takes over, so that the end of it is read
        pid = os.fork()
        if pid == 0:
            _be(arguments, err, begun, cold=cold)
        os.close(begun)
        os.read(begins, 1)
        os.close(begins)
        return cls(pid, err)

    def code(self, seconds: float) -> int | None:
        """The exit code as of `subprocess`, None where it is not there within so many seconds; asked for once only."""
        end = time.monotonic() + seconds
        while True:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                return os.waitstatus_to_exitcode(status)
            if time.monotonic() > end:
                return None
            time.sleep(POLL)

    def ended(self) -> int:
        """The exit code. Raises TimeoutError, and ends the process, where that takes too long."""
        code = self.code(PATIENCE)
        if code is None:
            os.kill(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)
            raise TimeoutError(f"it is still there after {PATIENCE:g} s: {self.err.read_text(errors='replace')}")
        return code


def _be(arguments: list[str], err: Path, begun: int, *, cold: bool) -> NoReturn:
    """The new process: it becomes the command, and never returns."""
    code = 1
    try:
        for number, file in ((0, os.devnull), (1, os.devnull), (2, err)):
            os.dup2(os.open(file, os.O_RDWR | os.O_CREAT | os.O_TRUNC), number)
        if cold:
            environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
            os.execve(sys.executable, [sys.executable, "-m", "robotid", *arguments], environment)
        sys.stdout, sys.stderr = open(1, "w", closefd=False), open(2, "w", closefd=False)  # noqa: SIM115
        with interruptible(last=True):
            os.close(begun)
            code = main(arguments)
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def kill(config: Path, folder: Path, number: signal.Signals, after: float, *, cold: bool) -> Kill:
    """Start a run of a configuration in a folder, send it a signal, and examine what is left."""
    before = _remains(folder)  # of a run that was killed: this one may end before it comes to remove them
    began = time.monotonic()
    command = _run(config, folder, cold=cold)
    code = command.code(after)
    if code is None:
        os.kill(command.pid, number)
        code = command.ended()
    wrong = [*_wrong_end(number, code, command.err.read_bytes()), *damage(folder)]
    if number is not signal.SIGKILL:
        wrong += [f"{name} is left" for name in sorted(_remains(folder) - before)]
    return Kill(number, time.monotonic() - began, code, tuple(wrong))


def _run(config: Path, folder: Path, *, cold: bool) -> Command:
    err = folder.with_suffix(".err")
    return Command.start(["run", str(config), "--out", str(folder), "--quiet"], err, cold=cold)


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
        command = Command.start([*arguments, "--out", str(folder)], folder.with_suffix(".err"), cold=False)
        code, err = command.ended(), command.err.read_text(errors="replace")
        if code or err:
            wrong.append(f"{arguments[0]} ends with {code}: {err}")
    wrong += [f"{stage.output} is absent" for stage in STAGES.values() if not (folder / stage.output).exists()]
    wrong += [f"{name} is left" for name in os.listdir(folder) if name.startswith(".") and name != KEPT_CHECK]
    return wrong + damage(folder)


def duration(config: Path, folder: Path) -> float:
    """Seconds that a whole run takes here, imports apart. This process is warm after it."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    warm_up(config, folder.with_name(f"{folder.name}-warm"))
    began = time.monotonic()
    assert _run(config, folder, cold=False).ended() == 0
    return time.monotonic() - began


def moment(rng: random.Random, whole: float, *, cold: bool) -> tuple[signal.Signals, float]:
    """Which signal, and when: the first second of a cold one, in which all is imported, gets its share."""
    return rng.choice(SIGNALS), rng.uniform(0.15, whole + IMPORTS) if cold else rng.uniform(0.0, whole)
