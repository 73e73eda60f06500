"""Every command of the README and the manual is understood; those of one's own data are run in `test_own_data`."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from support.manual.pages import FOLDER, Page, pages
from support.paths import ROOT

from robotid import errors
from robotid.cli.app import main
from robotid.pipeline.table import STAGES

COMMANDS = list(dict.fromkeys(command for page in pages() for command in (*page.shown, *page.inline)))
CONTRACT = Page(FOLDER / "command-line.md")
HARMLESS = ("--version", "explain", "example")
"""Commands that finish at once, and write into the current folder at most."""


def of_kind(kind: str) -> list[str]:
    return [command for command in COMMANDS if command.startswith(f"{kind} ")]


def test_every_command_is_of_a_kind_that_is_tested() -> None:
    assert {command.split()[0] for command in COMMANDS} == {"robotid", "make", "pip", "cd"}
    assert all(len(of_kind(kind)) >= least for kind, least in {"robotid": 25, "make": 6, "pip": 2}.items())


@pytest.mark.parametrize("command", [c for c in of_kind("robotid") if not c.startswith("robotid STAGE")])
def test_commands_are_understood(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = shlex.split(command)[1:]
    configs = [word for word in words if word.startswith("configs/")]
    if configs:
        assert all((ROOT / config).is_file() for config in configs)
        words = [str(ROOT / word) if word in configs else word for word in words]
        code = main([*words, "--dry-run", "--out", str(tmp_path)])
        said = capsys.readouterr().err
        assert code == 0 or "is missing; run `robotid" in said, said
    elif words[0] in HARMLESS and not any(word.isupper() for word in words[1:]):
        assert main(words) == 0, capsys.readouterr().err
    else:
        assert main([words[0], "--help"]) == 0
        options = {word for word in words if word.startswith("--")}
        shown = capsys.readouterr().out
        assert all(option in shown for option in options), shown


def test_an_example_of_the_readme_is_ready_to_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (write, run) = (shlex.split(c)[1:] for c in Page(ROOT / "README.md").shown if "hidden" in c)
    assert main(write) == 0
    assert main([*run, "--dry-run"]) == 0


@pytest.mark.parametrize("command", of_kind("make"))
def test_make_knows_its_targets(command: str) -> None:
    if shutil.which("make") is None:
        pytest.skip("there is no make here")
    words = [*shlex.split(command), "--dry-run", f"PYTHON={sys.executable}"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("command", of_kind("pip"))
def test_what_pip_installs_is_declared(command: str) -> None:
    what = shlex.split(command)[2]
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    package, _, extra = what.removesuffix("]").partition("[")
    assert package in (".", "robotid")
    assert not extra or extra in extras


def test_the_contract_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    commands = capsys.readouterr().out.partition("Commands")[2]
    listed = set(re.findall(r"^\W*([a-z][a-z-]+)  +\S", commands, re.MULTILINE))
    assert {"run", "fit", "example", "report"} <= listed
    assert {name for name in listed if not re.search(rf"`(robotid )?{name}\b", CONTRACT.text)} == set()


def test_the_contract_lists_the_artifact_of_every_stage() -> None:
    rows = dict(re.findall(r"^\| `([\w-]+)` \| `([\w.]+)`", CONTRACT.text, re.MULTILINE))
    assert rows == {name: stage.output for name, stage in STAGES.items()} | {"report": "report.html"}


def test_the_contract_lists_every_option_of_a_stage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", "--help"]) == 0
    options = set(re.findall(r"--[a-z-]+", capsys.readouterr().out)) - {"--help"}
    assert options == set(re.findall(r"^\| `(--[a-z-]+)", CONTRACT.text, re.MULTILINE))


def test_the_contract_lists_every_exit_code() -> None:
    kinds = [kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, errors.RobotidError)]
    codes = {0, errors.INTERRUPTED, *(kind.exit_code for kind in kinds)}
    assert codes == {int(code) for code in re.findall(r"^\| (\d+) \|", CONTRACT.text, re.MULTILINE)}
