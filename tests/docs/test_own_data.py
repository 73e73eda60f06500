"""The manual followed command by command: from two logs to a cause, a gain, a report and files for other programs."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml
from support.manual.pages import FOLDER, README, Page

OWN, FRONT, CONTRACT = Page(FOLDER / "own-data.md"), Page(README), Page(FOLDER / "command-line.md")
CONFIGURATION = OWN.fenced("yaml")[0]
EXAMPLES = {"dFs", "m3", "set1"}  # keys of the contract's JSON that are names of parameters, models and records
# there is a twin, an unknown effect, a difference of a held-out record, an event, or a tone
UNKNOWN = {"along", "x", "missing_torque"}
EVENT = {"record", "kind", "of", "gradual", "from", "to", "torque", "std", "p_value", "frequency"}
OPTIONAL = {"separate_by", "excite", *UNKNOWN, "explained_of", "beside", *EVENT}


@dataclass(frozen=True)
class Desk:
    """A folder in which all commands of the page were typed, and what each of them printed."""

    folder: Path
    out: Mapping[str, str]
    err: Mapping[str, str]

    def json(self, stage: str) -> dict[str, Any]:
        """The document of a stage that is up to date."""
        found: dict[str, Any] = json.loads(typed(self.folder, f"robotid {stage} mine.yaml --json").stdout)
        return found


def typed(folder: Path, command: str) -> subprocess.CompletedProcess[str]:
    """A command of the manual, run in a process of its own."""
    words = [sys.executable, "-m", "robotid", *shlex.split(command)[1:]]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}\n{done.stderr}"
    return done


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    """The page followed from its first command to its last."""
    folder = tmp_path_factory.mktemp("desk")
    done = {}
    for command in OWN.shown:
        if command.startswith("cd "):
            folder = folder / command.removeprefix("cd ")
            continue
        done[command] = typed(folder, command)
        if command.startswith("robotid new"):
            (folder / "mine.yaml").write_text(CONFIGURATION)
    return Desk(folder, {c: d.stdout for c, d in done.items()}, {c: d.stderr for c, d in done.items()})


def split(line: str) -> tuple[str, list[float]]:
    """Words and numbers of a line."""
    number = r"\d+(?:\.\d+)?"
    return re.sub(number, "#", line), [float(one) for one in re.findall(number, line)]


def test_the_page_leaves_what_it_promises(desk: Desk) -> None:
    made = {"mine.yaml", "mine.mat", "signals_log.csv", "signals_day2.csv", "validation.png", "runs/mine/extended.yaml"}
    assert [name for name in made if not (desk.folder / name).exists()] == []
    assert len(list((desk.folder / "figures").glob("*.pdf"))) > 10
    assert (desk.folder / "runs" / "mine-extended" / "report.html").exists()


def test_the_cause_is_named_with_its_parameters_and_its_gain(desk: Desk) -> None:
    assert "motor.stribeck" in desk.out["robotid diagnose mine.yaml"]
    (cause,) = desk.json("diagnose")["causes"]
    assert cause["effect"] == "motor.stribeck"
    assert cause["parameters"]["dFs"]["value"] == pytest.approx(0.25, rel=0.05)
    assert cause["parameters"]["vs"]["value"] == pytest.approx(2.0, rel=0.05)
    assert cause["explained"] > 0.98
    assert cause["heldout_gain"] > 3.5


@pytest.mark.parametrize("page", [OWN, FRONT], ids=["own-data.md", "README.md"])
def test_the_closing_lines_are_those_of_the_run(page: Page, desk: Desk) -> None:
    """To a percent: the logs come from a virtual robot, and another processor draws another error of its encoder."""
    (closing,) = (block for block in page.fenced("text") if "simulates log to" in block)
    printed = dict(map(split, desk.err["robotid run mine.yaml"].splitlines()))
    for words, numbers in map(split, closing.splitlines()):
        assert printed[words] == pytest.approx(numbers, rel=0.01, abs=0.02)


def test_the_readme_shows_a_part_of_the_same(desk: Desk) -> None:
    own = [command for command in FRONT.shown if "mine" in command]
    assert len(own) == 4
    assert set(own) <= set(desk.out)
    (shown,) = FRONT.fenced("yaml")
    assert yaml.safe_load(shown) == yaml.safe_load(CONFIGURATION)


def test_the_python_of_the_readme_finds_the_same(desk: Desk) -> None:
    (shown,) = FRONT.fenced("python")
    asked = "print(*(cause.effect for cause in found.causes), *better.added)"
    command = [sys.executable, "-c", f"{shown}\n{asked}"]
    done = subprocess.run(command, cwd=desk.folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["motor.stribeck", "motor.stribeck"]


@pytest.mark.parametrize("stage", ["init-rigid", "fit", "validate", "diagnose", "extend"])
def test_the_json_of_a_stage_has_the_keys_of_the_contract(stage: str, desk: Desk) -> None:
    shown = CONTRACT.text.partition(f"`{stage} --json`")[2].partition("```text\n")[2].partition("```")[0]
    values = set(re.findall(r': "(\w+)"|\| "(\w+)"', shown))
    quoted = set(re.findall(r'"(\w+)"', shown)) - EXAMPLES - OPTIONAL - {one for pair in values for one in pair}
    assert len(quoted) >= 5
    printed = json.dumps(desk.json(stage))
    assert {key for key in quoted if f'"{key}":' not in printed} == set()
