"""Exit codes and the discipline of the two streams."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest

from robotid import __version__
from robotid.cli.app import main
from robotid.errors import ConfigError, InputError, NumericsError, RobotidError, ThresholdError
from robotid.pipeline.table import PRODUCTS


def raising(error: BaseException) -> Callable[..., NoReturn]:
    def stand_in(*arguments: object, **options: object) -> NoReturn:
        raise error

    return stand_in


@pytest.fixture
def broken(monkeypatch: pytest.MonkeyPatch) -> Callable[[BaseException], int]:
    """Run `fit` with a pipeline that raises."""

    def run(error: BaseException, *options: str) -> int:
        monkeypatch.setattr("robotid.cli.perform.open_run", raising(error))
        return main(["fit", "a.yaml", *options])

    return run


def test_the_commands_are_the_products_of_the_pipeline(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    listed = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]
    summaries = {words[0]: words[1] for words in listed if len(words) == 2}
    for name, product in PRODUCTS.items():
        assert product.summary.startswith(summaries[name].removesuffix("...").strip())


@pytest.mark.parametrize("kind", [ConfigError, InputError, NumericsError, ThresholdError])
def test_an_error_is_one_line_and_its_exit_code(
    kind: type[RobotidError], broken: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    assert broken(kind("it cannot be", where="a.yaml:3  fit", hint="do this")) == kind.exit_code
    assert capsys.readouterr() == ("", "a.yaml:3  fit: it cannot be; do this\n")


def test_debug_shows_where_it_came_from(broken: Callable[..., int], capsys: pytest.CaptureFixture[str]) -> None:
    assert broken(InputError("it cannot be"), "--debug") == 3
    err = capsys.readouterr().err
    assert err.startswith("Traceback")
    assert err.endswith("\nit cannot be\n")


def test_a_bug_of_ours(broken: Callable[..., int], capsys: pytest.CaptureFixture[str]) -> None:
    assert broken(ZeroDivisionError("division by zero")) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("Traceback")
    assert err.endswith("this is a bug in robotid; please report it with the lines above\n")


def test_a_full_disk_is_no_bug(broken: Callable[..., int], capsys: pytest.CaptureFixture[str]) -> None:
    assert broken(OSError(28, "No space left on device", "runs/a/model.h5")) == 3
    assert capsys.readouterr().err == "runs/a/model.h5: No space left on device\n"


def test_an_interrupt(broken: Callable[..., int], capsys: pytest.CaptureFixture[str]) -> None:
    assert broken(KeyboardInterrupt()) == 130
    assert capsys.readouterr() == ("", "interrupted\n")


@pytest.mark.parametrize(
    "arguments",
    [["fti"], ["fit"], ["fit", "a.yaml", "--jbos", "2"], ["fit", "a.yaml", "--jobs", "0"], ["explain", "a", "b"]],
)
def test_wrong_usage(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("Usage: robotid")


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr() == (f"robotid {__version__}\n", "")


THREADS = """
import os
from robotid.cli.app import main
main(["fit", "absent.yaml", "--jobs", "3"])
print(os.environ["OPENBLAS_NUM_THREADS"])
"""


def test_linear_algebra_uses_one_thread_whatever_is_asked_for() -> None:
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "4"}
    done = subprocess.run([sys.executable, "-c", THREADS], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout == "1\n"


@pytest.mark.parametrize(("variable", "what"), [("2", "no such file"), ("none", "--jobs"), ("0", "--jobs")])
def test_the_environment_tells_how_many_processes(
    variable: str, what: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("ROBOTID_JOBS", variable)
    assert main(["fit", "absent.yaml"]) == 2
    assert what in capsys.readouterr().err


def test_completion_is_there(tmp_path: Path) -> None:
    environment = {
        "_ROBOTID_COMPLETE": "complete_bash",
        "COMP_WORDS": "robotid init",
        "COMP_CWORD": "1",
        "HOME": str(tmp_path),
    }
    done = subprocess.run(
        [sys.executable, "-m", "robotid"], capture_output=True, text=True, env=environment, cwd=Path.cwd()
    )
    assert done.stdout.split() == ["init-rigid", "init-flex"]
