"""Reading configurations: completion, canonical text, YAML's corners."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotid.config.load import load, parse, resolved
from robotid.errors import ConfigError

RIGID = """\
robot: {name: axis, model: {motor: [inertia, viscous]}}
records:
  - &first {name: day1, file: day1.csv}
  - {<<: *first, name: day2, role: validate}
"""
VIRTUAL = """\
robot: {name: axis, model: {motor: [inertia]}}
records:
  - name: wave
    excite: {kind: multisine, band: [1, 10], period: 1, peak: 2, sampling_time: 0.01, realisations: 3}
  - {name: last, role: validate, excite: {kind: triangle, amplitude: 1, period: 1, sampling_time: 0.01}}
plant: {parameters: {motor.inertia.J: 1}, controller: {kind: speed, kp: 1}}
"""


def test_models_are_completed_from_the_records() -> None:
    config = parse(RIGID)
    assert config.fit.models == {"m1": ("day1",)}
    assert config.fit.best == "m1"


def test_the_last_model_is_the_best_unless_told() -> None:
    config = parse(RIGID, overrides=["fit.models={a: [day1], b: [day1]}"])
    assert config.fit.best == "b"


def test_realisations_are_records_of_their_own() -> None:
    config = parse(VIRTUAL)
    assert config.names("estimate") == ("wave", "wave_r2", "wave_r3")
    assert config.fit.models == {"m1": ("wave", "wave_r2", "wave_r3")}
    assert parse(VIRTUAL, overrides=["fit.models.m1=[wave_r3]"]).fit.models == {"m1": ("wave_r3",)}


def test_the_virtual_robot_is_like_the_model_unless_told() -> None:
    assert parse(VIRTUAL).plant_structure().terms == ("motor.inertia",)
    changed = ["plant.model={motor: [inertia, coulomb]}", "plant.parameters.motor.coulomb.Fc=0.5"]
    config = parse(VIRTUAL, overrides=changed)
    assert config.plant_structure().terms == ("motor.inertia", "motor.coulomb")
    assert config.structure().terms == ("motor.inertia",)


def test_the_plants_controller_closes_the_loop_unless_another_is_known() -> None:
    config = parse(VIRTUAL)
    assert config.plant is not None
    assert config.loop == config.plant.controller
    assert parse(RIGID).loop is None


def test_merged_mappings_keep_their_own_keys() -> None:
    second = parse(RIGID).records[1]
    assert (second.name, second.file, second.role) == ("day2", "day1.csv", "validate")


@pytest.mark.parametrize("text", [RIGID, VIRTUAL])
def test_the_resolved_text_means_the_same(text: str) -> None:
    config = parse(text)
    assert parse(resolved(config)) == config
    assert resolved(parse(resolved(config))) == resolved(config)


def test_a_column_that_is_left_out_is_not_one_that_is_not_there() -> None:
    config = parse(RIGID, overrides=["records.day1.columns={t: time, dphi_m: null, phi_m: {name: enc, unit: deg}}"])
    again = parse(resolved(config)).records[0].columns
    assert again is not None
    assert again == config.records[0].columns
    assert again.model_fields_set == {"t", "dphi_m", "phi_m"}


def test_a_section_has_one_text_however_it_is_written(tmp_path: Path) -> None:
    short, long = tmp_path / "short.yaml", tmp_path / "long.yaml"
    short.write_text(RIGID)
    long.write_text(RIGID + "# a remark\nfit:\n  best: m1\n  models:\n    m1:\n      - day1\ninit_rigid: {order: 4}\n")
    first, second = load(short), load(long)
    for section in ("robot", "records", "fit", "init_rigid", "validate"):
        assert first.section_text(section) == second.section_text(section)
    changed = load(short, ["init_rigid.order=5"])
    assert first.section_text("init_rigid") != changed.section_text("init_rigid")
    assert first.section_text("fit") == changed.section_text("fit")


def test_a_file_knows_its_folder(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(RIGID)
    assert load(path).directory == tmp_path
    assert load(path).config.structure().terms == ("motor.inertia", "motor.viscous")


@pytest.mark.parametrize(
    ("written", "meant"), [("1e6", 1e6), ("1.5E+6", 1.5e6), ("2", 2.0), (".5", 0.5), ("-3.", -3.0), ("+1e-3", 1e-3)]
)
def test_numbers(written: str, meant: float) -> None:
    bounds = f"robot.parameters.motor.viscous.Fv={{guess: {written}, bounds: [-.inf, .inf]}}"
    assert parse(RIGID, overrides=[bounds]).robot.parameters["motor.viscous.Fv"].guess == meant


@pytest.mark.parametrize("word", ["yes", "no", "on", "off", "1:30", "2026-11-21", "0x10", "1_000"])
def test_what_older_yaml_took_for_something_else_is_a_word(word: str) -> None:
    assert parse(RIGID, overrides=[f"records.0.file={word}"]).records[0].file == word


def test_a_word_is_not_a_number() -> None:
    with pytest.raises(ConfigError, match=r'expected a number, found "1e6"'):
        parse(RIGID, overrides=['init_rigid.cutoff="1e6"'])


def test_errors_point_into_merged_and_aliased_text() -> None:
    with pytest.raises(ConfigError) as caught:
        parse(RIGID.replace("file: day1.csv", "flie: day1.csv"), "a.yaml")
    assert str(caught.value) == 'a.yaml:3  records[0].flie: there is no key "flie"; did you mean file?'
