from dataclasses import fields

import numpy as np
import pytest

from robotid.config.load import parse
from robotid.errors import ConfigError
from robotid.signals.multisine import crest_factor
from robotid.signals.reference import Excitation
from robotid.signals.waves import square, triangle
from robotid.stages.excite import excite

ROBOT = """
robot:
  name: irb
  gear_ratio: 0.01
  model: {motor: [inertia, viscous, coulomb], gear: [spring], arm: [inertia]}
  parameters:
    motor.inertia.J: {guess: 0.01}
    arm.inertia.J: {guess: 100}
    motor.viscous.Fv: {guess: 0.02}
    %s
plant:
  parameters:
    {motor.inertia.J: 0.01, motor.viscous.Fv: 0.02, motor.coulomb.Fc: 0.6, gear.spring.k1: 1.0e6, arm.inertia.J: 100.0}
  controller: {kind: speed, kp: 1.0}
records:
"""
MODELS = "\nfit: {models: {m1: [a]}}\n"
FLAT = "{kind: multisine, band: [1, 40], period: 5, peak: 5}"
SQUARE = "{kind: square, amplitude: 8, period: 5}"
PAPER = f"""
  - {{name: set1, excite: {{kind: triangle, amplitude: 40, period: 5, duration: 6.25, sampling_time: 0.0005}}}}
  - {{name: set2, excite: {{kind: sum, sampling_time: 0.0005, duration: 5, of: [{FLAT}, {SQUARE}]}}}}
"""


def run(records: str, coulomb: str = "motor.coulomb.Fc: {guess: 0.6}") -> Excitation:
    return excite(parse(ROBOT % coulomb + records))


def one(block: str) -> Excitation:
    return run(f"  - {{name: a, excite: {block}}}")


def amplitudes(signal: np.ndarray) -> np.ndarray:
    return np.asarray(np.abs(np.fft.rfft(signal)) * 2 / len(signal))


@pytest.fixture(scope="module")
def paper() -> Excitation:
    return run(PAPER)


def test_the_papers_set_1(paper: Excitation) -> None:
    reference = paper["set1"]
    assert np.array_equal(reference.ref, triangle(40.0, 10_000, 12_500))
    assert (reference.kind, reference.sampling_time, reference.period) == ("speed", 0.0005, 5.0)
    assert (reference.band, len(reference.lines), reference.crest_factor) == (None, 0, None)


def test_the_papers_set_2(paper: Excitation) -> None:
    reference = paper["set2"]
    assert (len(reference), reference.period, reference.band) == (10_000, 5.0, (1.0, 40.0))
    alone = reference.ref - square(8.0, 10_000, 10_000)
    assert np.abs(alone).max() == pytest.approx(5.0, abs=1e-12)
    assert crest_factor(alone) <= 1.5
    assert reference.crest_factor == pytest.approx(crest_factor(alone), rel=2e-3)
    flat = amplitudes(alone)
    assert flat[5:201] == pytest.approx(flat[5], abs=1e-12)
    assert np.delete(flat, np.arange(5, 201)).max() < 1e-12


def test_a_sum_is_the_sum_of_its_parts() -> None:
    falling = "{kind: multisine, period: 5, spectrum: [[1, 0.5], [9, 0.1]], crest_factor: null, seed: 4%s}"
    timing = ", sampling_time: 0.01"
    total = one(f"{{kind: sum, sampling_time: 0.01, of: [{falling % ''}, {SQUARE}]}}")["a"]
    parts = one(falling % timing)["a"].ref + one(SQUARE.replace("}", f"{timing}}}"))["a"].ref
    assert total.ref == pytest.approx(parts, abs=1e-13)


def test_parts_of_different_periods_repeat_together() -> None:
    two = "{kind: square, amplitude: 1, period: 2}"
    reference = one(f"{{kind: sum, sampling_time: 0.01, periods: 2, of: [{SQUARE}, {two}]}}")["a"]
    assert (reference.period, len(reference)) == (10.0, 2_000)
    assert np.array_equal(reference.ref[:1_000], reference.ref[1_000:])


def test_periods_repeat() -> None:
    reference = one(FLAT.replace("}", ", crest_factor: null, sampling_time: 0.01, periods: 3}"))["a"]
    assert np.array_equal(reference.ref.reshape(3, 500), np.tile(reference.ref[:500], (3, 1)))


def test_less_than_a_period_has_no_period() -> None:
    assert one("{kind: triangle, amplitude: 1, period: 5, duration: 2, sampling_time: 0.01}")["a"].period is None


def test_realisations_differ_in_phase_alone() -> None:
    block = FLAT.replace("}", ", crest_factor: null, sampling_time: 0.01, realisations: 3}")
    references = one(block).references
    assert [(r.name, r.block, r.realisation) for r in references] == [("a", "a", 1), ("a_r2", "a", 2), ("a_r3", "a", 3)]
    first, second, third = (r.ref for r in references)
    assert max(np.abs(r.ref).max() for r in references) == pytest.approx(5.0, abs=1e-12)
    assert amplitudes(first) == pytest.approx(amplitudes(second), abs=1e-12)
    assert amplitudes(first) == pytest.approx(amplitudes(third), abs=1e-12)
    assert abs(np.corrcoef([first, second, third])[np.triu_indices(3, 1)]).max() < 0.5


def test_seeds() -> None:
    block = FLAT.replace("}", ", sampling_time: 0.01, seed: %d}")
    first, again, other = (one(block % seed)["a"].ref for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.allclose(first, other)


def test_spectrum_without_peak_is_taken_as_it_stands() -> None:
    """Linear between the points, and zero beyond them."""
    reference = one(
        "{kind: multisine, period: 1, spectrum: [[2, 0.5], [4, 1.5], [5, 0]], sampling_time: 0.01, crest_factor: 4}"
    )
    assert amplitudes(reference["a"].ref)[:8] == pytest.approx([0, 0, 0.5, 1.0, 1.5, 0, 0, 0], abs=1e-12)
    assert reference["a"].lines.tolist() == [2.0, 3.0, 4.0]


def test_the_controller_must_follow_what_is_prescribed() -> None:
    record = "  - {name: a, excite: {kind: triangle, amplitude: 1, period: 5, sampling_time: 0.01, quantity: position}}"
    text = ROBOT % "" + record
    follows = parse(text, overrides=("plant.controller.kind=position", "plant.controller.kpos=10.0"))
    assert excite(follows)["a"].kind == "position"
    with pytest.raises(ConfigError) as error:
        excite(parse(text))
    assert str(error.value) == (
        "a: the excitation prescribes a position, but the controller of the plant follows a speed; "
        "give the excitation quantity: speed, or another controller"
    )


def test_records_with_files_are_passed_over() -> None:
    assert run("  - {name: a, file: a.csv}").references == ()


def test_torque_of_the_rigid_joint_keeps_its_limit() -> None:
    """Inertia 0.01 + 0.01^2 * 100, 32 rad/s2, up to 40 rad/s: 0.64 + 0.8 + 0.6 Nm at the end of the rise."""
    block = "{kind: triangle, amplitude: 40, period: 5, sampling_time: 0.0005, limits: {torque: %s}}"
    one(block % "2.0401")
    with pytest.raises(ConfigError) as error:
        one(block % "2")
    assert error.value.what == "the torque reaches 2.04 Nm at 1.25 s, the limit is 2 Nm"
    assert error.value.where == "a"


def test_torque_needs_guesses() -> None:
    block = "{kind: triangle, amplitude: 40, period: 5, sampling_time: 0.01, limits: {torque: 2}}"
    with pytest.raises(ConfigError) as error:
        run(f"  - {{name: a, excite: {block}}}", coulomb="motor.coulomb.Fc: {bounds: [0, 1]}")
    assert str(error.value) == "a: a limit of torque needs a guess of motor.coulomb.Fc; give it under robot.parameters"


def test_limits_of_every_realisation() -> None:
    """The largest realisation alone reaches the peak."""
    block = FLAT.replace("}", ", crest_factor: null, sampling_time: 0.01, realisations: 4, limits: {speed: 4.99}}")
    with pytest.raises(ConfigError, match=r"^a_r2: the speed reaches 5 rad/s at "):
        one(block)


def test_a_crest_factor_that_cannot_be_had() -> None:
    with pytest.raises(ConfigError) as error:
        one("{kind: multisine, band: [1, 1], period: 1, peak: 5, crest_factor: 1.4, sampling_time: 0.01}")
    assert str(error.value) == (
        "a: no phases were found for a crest factor of 1.4, only for 1.414; "
        "ask for crest_factor: 1.42, or null for random phases"
    )


def test_a_spectrum_between_two_lines() -> None:
    with pytest.raises(ConfigError) as error:
        one("{kind: multisine, period: 1, spectrum: [[1, 0], [1.5, 1], [2, 0]], sampling_time: 0.01}")
    assert str(error.value) == "a: the spectrum is zero on every line; lengthen the period"


def test_a_record_called_like_a_realisation() -> None:
    block = FLAT.replace("}", ", crest_factor: null, sampling_time: 0.01, realisations: 2}")
    settings = parse(ROBOT % "" + f"  - {{name: a, excite: {block}}}\n  - {{name: a_r2, file: a.csv}}" + MODELS)
    with pytest.raises(ConfigError) as error:
        excite(settings)
    assert str(error.value) == (
        "a_r2: two references have this name; rename that record: it is what realisation 2 of a is called"
    )


def test_references_are_made_of_what_an_artifact_can_hold(paper: Excitation) -> None:
    """Every field with a physical unit declares it."""
    declared = {f.name: f.metadata.get("unit") for f in fields(paper["set1"])}
    assert [name for name, unit in declared.items() if unit] == ["sampling_time", "ref", "period", "band", "lines"]
