"""A run in several processes: the numbers of a run in one, and nothing that stays behind where it is stopped."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import is_dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from support.alike import alike
from support.paths import ROOT
from support.small_bench import QUICK, STRIBECK, fitted, records

from robotid.config.load import load
from robotid.diagnosis import Diagnosis, DiagnosisOptions, diagnose
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.grey_box import FitOptions
from robotid.extension import Extension, diagnose_with_gains, extend, extension_task, with_gains
from robotid.parallel import computing, pool, working
from robotid.pipeline.execute import execute_all
from robotid.pipeline.run import Run

SMOKE = ROOT / "configs" / "smoke.yaml"


@pytest.fixture(autouse=True)
def _processes_start_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "START_UP", 0.0)
    monkeypatch.setattr(pool, "HAND_OVER", 0.0)


def contents(out: Path, jobs: int) -> list[Any]:
    """What all stages of a short run find, but for the time that they take."""
    with working(jobs):
        outcomes = list(execute_all(Run(load(SMOKE), out)))
    return [untimed(one.content) for one in outcomes]


def untimed(content: Any) -> Any:
    """The content with all times of work set to zero."""
    if isinstance(content, dict):
        return {key: untimed(value) for key, value in content.items()}
    if not is_dataclass(content) or isinstance(content, type):
        return content
    nested = {name: untimed(getattr(content, name)) for name in ("models", "fit", "extended") if hasattr(content, name)}
    return replace(content, **nested, **({"seconds": 0.0} if hasattr(content, "seconds") else {}))


def test_every_stage_finds_the_same_in_two_processes(tmp_path: Path) -> None:
    pytest.importorskip("loky", reason="processes need loky")
    one, two = contents(tmp_path / "one", 1), contents(tmp_path / "two", 2)
    assert len(one) == len(two)
    for a, b in zip(one, two, strict=True):
        assert alike(a, b), type(a)


def found(jobs: int) -> tuple[Diagnosis, Extension]:
    """A diagnosis that names a cause, and the extension by it."""
    made = records(STRIBECK)
    fit = replace(fitted(made), seconds=0.0)
    with computing(jobs):
        diagnosis = diagnose_with_gains(fitted_model(fit), fit, made, FitOptions(output=fit.output), QUICK)
        task = extension_task(diagnosis, fit, made)
        extension = extend(task, [cause.effect for cause in diagnosis.causes])
    return untimed(diagnosis), untimed(extension)


def test_a_cause_is_the_same_in_two_processes_and_on_two_threads() -> None:
    pytest.importorskip("loky", reason="processes need loky")
    threadpoolctl = pytest.importorskip("threadpoolctl")
    one = found(1)
    assert [cause.effect for cause in one[0].causes] == ["motor.stribeck"]
    assert alike(one, found(2))
    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        assert alike(one, found(1))


def test_gains_are_those_of_fits_after_the_diagnosis() -> None:
    made = records(STRIBECK)
    fit = replace(fitted(made), seconds=0.0)
    diagnosis = diagnose(fit, made, QUICK, DiagnosisOptions())
    afterwards = with_gains(diagnosis, extension_task(diagnosis, fit, made), QUICK)
    assert alike(untimed(afterwards), found(1)[0])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_no_process_behind(tmp_path: Path, number: signal.Signals) -> None:
    script = (
        "import sys\n"
        "from robotid.parallel import pool\n"
        "pool.START_UP = 0.0\n"
        "from robotid.cli.app import main\n"
        f"sys.exit(main(['run', {str(SMOKE)!r}, '--out', {str(tmp_path / 'run')!r}, '--jobs', '2', '--force']))\n"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    with subprocess.Popen(
        [sys.executable, "-c", script], env=environment, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as run:
        assert run.stderr is not None
        while "init-flex" not in (line := run.stderr.readline()):
            assert line, "the run ended before its fit"
        time.sleep(1.0)
        if number == signal.SIGINT:  # as a terminal does, to all of them
            os.killpg(run.pid, number)
        else:
            run.send_signal(number)
        rest = run.stderr.read()
        assert run.wait(60) in (130, 0)
    assert "Traceback" not in rest
    assert nobody_in(run.pid)


def nobody_in(group: int) -> bool:
    """Whether all processes of a group end in a few seconds."""
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False
