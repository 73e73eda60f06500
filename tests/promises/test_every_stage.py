"""Promises over the whole table of stages, on the configuration that CI runs."""

from __future__ import annotations

import ast
from collections import defaultdict
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from support.alike import alike
from support.paths import CONFIGS

import robotid
from robotid.artifacts.store import load as load_artifact
from robotid.artifacts.store import read_header, save
from robotid.config.load import load
from robotid.config.schema import Config
from robotid.pipeline.execute import Outcome, execute_all
from robotid.pipeline.run import Run
from robotid.pipeline.stage import Stage, find
from robotid.pipeline.table import PRODUCTS, STAGES
from robotid.report.findings import Findings

SMOKE = CONFIGS / "smoke.yaml"
PACKAGE = Path(robotid.__file__).parent


class Watched:
    """A configuration that notes which of its sections are read, by its own methods too."""

    def __init__(self, config: Config, read: set[str]) -> None:
        self._config, self._read = config, read

    def __getattr__(self, name: str) -> Any:
        field = Config.model_fields.get(name)
        if field is not None:
            self._read.add(field.alias or name)
            return getattr(self._config, name)
        member = getattr(Config, name)
        return member.fget(self) if isinstance(member, property) else partial(member, self)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return Run(load(SMOKE), tmp_path_factory.mktemp("smoke"))


@pytest.fixture(scope="module")
def read() -> dict[str, set[str]]:
    return defaultdict(set)


@pytest.fixture(scope="module")
def outcomes(run: Run, read: dict[str, set[str]]) -> list[Outcome]:
    """Every stage, with a note of the sections that each has read."""

    def watched(stage: Stage, config: Config, *inputs: Any, **options: Any) -> Any:
        return find(stage.function)(Watched(config, read[stage.name]), *inputs, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Stage, "__call__", watched)
        return list(execute_all(run))


def test_every_stage_runs_in_order(outcomes: list[Outcome]) -> None:
    assert [outcome.stage for outcome in outcomes if outcome.ran] == list(STAGES)


def test_inputs_come_before(outcomes: list[Outcome]) -> None:
    names = list(STAGES)
    for stage in STAGES.values():
        assert all(names.index(name) < names.index(stage.name) for name in stage.inputs)
    assert len({stage.output for stage in STAGES.values()}) == len(STAGES)


@pytest.mark.parametrize("name", PRODUCTS)
def test_a_row_states_everything(name: str) -> None:
    row = PRODUCTS[name]
    assert row.summary[0].isupper()
    assert row.summary.endswith(".")
    assert row.heading[0].isupper()
    assert row.tables == f"robotid.report.tables.{name.replace('-', '_')}"
    assert all(callable(getattr(row.view(), function)) for function in ("tables", "document"))
    if isinstance(row, Stage):
        assert callable(find(row.function))
        assert row.type().__name__ == row.kind
        assert row.finding in {field.name for field in fields(Findings)}
        assert not row.export or callable(find(row.export))
        assert row.companion is None or callable(find(row.companion.function))


def test_every_field_of_the_findings_is_of_one_stage() -> None:
    beside_the_stages = {"robot", "linear", "horizon", "estimate_states", "evidence"}
    found = [stage.finding for stage in STAGES.values()]
    assert sorted(found) == sorted({field.name for field in fields(Findings)} - beside_the_stages)


def test_no_other_module_has_a_table_of_stages() -> None:
    """A mapping or a sequence of several of their names, written out, stands in `pipeline.table` alone; the front door
    has functions of such names."""
    functions, rows = PACKAGE / "__init__.py", PACKAGE / "pipeline" / "table.py"
    for file in sorted(set(PACKAGE.rglob("*.py")) - {functions, rows}):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            items = node.keys if isinstance(node, ast.Dict) else getattr(node, "elts", [])
            words = {item.value for item in items if isinstance(item, ast.Constant)}
            named = words & STAGES.keys() - {"fit", "validate"}  # words of the configuration and of JSON as well
            assert len(named) < 2, f"{file.name}:{node.lineno} lists {named}"  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", STAGES)
def test_the_sections_that_a_stage_reads_count(name: str, outcomes: list[Outcome], read: dict[str, set[str]]) -> None:
    assert read[name]
    assert read[name] <= set(STAGES[name].sections)


@pytest.mark.parametrize("name", STAGES)
def test_content_is_what_was_saved(name: str, outcomes: list[Outcome]) -> None:
    outcome = next(o for o in outcomes if o.stage == name)
    assert alike(load_artifact(outcome.file, STAGES[name].type()).content, outcome.content)


@pytest.mark.parametrize("name", STAGES)
def test_saving_again_gives_the_same_digest(name: str, outcomes: list[Outcome], tmp_path: Path) -> None:
    file = next(o for o in outcomes if o.stage == name).file
    artifact = load_artifact(file, STAGES[name].type())
    save(tmp_path / file.name, artifact.content, artifact.provenance)
    assert read_header(tmp_path / file.name).digest == artifact.header.digest


def test_the_same_configuration_gives_the_same_content(outcomes: list[Outcome], run: Run, tmp_path: Path) -> None:
    again = Run(run.loaded, tmp_path)
    for first, second in zip(outcomes[:4], execute_all(again), strict=False):
        assert read_header(first.file).digest == read_header(second.file).digest
