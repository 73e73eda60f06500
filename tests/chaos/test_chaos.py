"""A short chaos for every change: `make chaos` has more of it."""

from __future__ import annotations

import random
import re
import shutil
import signal
from pathlib import Path

import pytest
from support.forgery import WAYS, datasets

from chaos.forgeries import COMMANDS, Forgery, drawn, wrong_with
from chaos.kills import completion, configuration, duration, kill, moment
from chaos.mutations import complaint, mutated, subjects
from robotid.pipeline.table import STAGES

SEED = 16


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, float]:
    """A configuration, the directory of a whole run of it, and the seconds that it took."""
    folder = tmp_path_factory.mktemp("chaos")
    config = configuration(folder)
    return config, folder / "run", duration(config, folder / "run")


def test_a_run_that_is_killed_is_whole_and_the_next_one_completes_it(
    run: tuple[Path, Path, float], tmp_path: Path
) -> None:
    rng = random.Random(SEED)
    for k in range(6):
        number, after = moment(rng, 0.7 * run[2], cold=k == 0)
        found = kill(run[0], tmp_path / "run", signal.SIGINT if k == 0 else number, after, cold=k == 0)
        assert found.wrong == (), found
    assert completion(run[0], tmp_path / "run") == []


@pytest.mark.filterwarnings("ignore")
def test_a_damaged_file_is_one_line_and_an_exit_code(run: tuple[Path, Path, float], tmp_path: Path) -> None:
    rng = random.Random(SEED)
    found = subjects(tmp_path, run[1])
    whole = {subject.file: subject.file.read_bytes() for subject in found}
    for k in range(120):
        subject = found[k % len(found)]
        content = mutated(whole[subject.file], rng, binary=subject.binary)
        wrong = complaint(subject, content)
        shutil.rmtree(tmp_path / f"run-{subject.file.suffix[1:]}", ignore_errors=True)
        assert not wrong, f"{k}: {subject.file.name}: {wrong}"


def test_an_artifact_with_a_forged_array_is_refused_or_shown(run: tuple[Path, Path, float], tmp_path: Path) -> None:
    """An array of every kind, altered in one way after another, under a checksum that fits."""
    refused, ways = 0, list(WAYS)
    for stage in STAGES.values():
        kinds = {
            re.sub(r"(?<=/)(\d+|slow)(?=/|$)", "*", name): name for name in datasets(run[1] / stage.output, arrays=True)
        }
        for k, name in enumerate(kinds.values()):
            forgery = Forgery(stage.output, name, ways[k % len(ways)])
            loaded, wrong = wrong_with(forgery, run[0], run[1], tmp_path, ("show",))
            assert not wrong, f"{forgery}: {wrong}"
            refused += not loaded
    assert refused > 30


def test_a_forged_value_is_refused_or_harmless_to_every_command(run: tuple[Path, Path, float], tmp_path: Path) -> None:
    """Numbers, shapes, types and attributes drawn at random; `make chaos` draws more."""
    loads = 0
    for k, forgery in enumerate(drawn(run[1], random.Random(SEED))[:40]):
        commands = COMMANDS if k % 40 == 0 else COMMANDS[:1]
        loaded, wrong = wrong_with(forgery, run[0], run[1], tmp_path, commands)
        assert not wrong, f"{forgery}: {wrong}"
        loads += loaded
    assert 0 < loads < 40
