"""Every mistake of a log is found by its check, and a log without one is not accused of any."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from support.mistaken_logs import (
    FLEXIBLE,
    MISTAKES,
    RATIO,
    RIGID,
    H,
    Log,
    Mistake,
    N,
    log_of,
    right_log,
    swing,
    without_speed,
)
from support.paths import CONFIGS

from robotid.config.load import load
from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.signals.plausibility import CHECKS, Axis, Plausibility, check_records, refuse_meaningless
from robotid.signals.plausibility.evidence import Evidence
from robotid.signals.plausibility.finding import Finding
from robotid.signals.quality import Recordings, inspect
from robotid.signals.record import Record
from robotid.stages.collect import collect
from robotid.stages.excite import excite

AXES = {"rigid": Axis(), "flexible": Axis(RATIO)}
CASES = [(kind, speed, mistake) for mistake in MISTAKES for kind in mistake.kinds for speed in mistake.speeds]


def record(log: Log, name: str = "log") -> Record:
    h = float(log["t"][-1] - log["t"][-2])
    return Record.from_arrays(log["tau_m"], log["phi_m"], h, speed=log.get("dphi_m"), name=name)


def findings(*records: Record, axis: Axis | None = None, accepted: tuple[str, ...] = ()) -> Plausibility:
    reports = tuple(inspect(one, one.name) for one in records)
    return check_records(Recordings(records, reports), axis or Axis(), accepted)


@pytest.mark.parametrize(
    ("kind", "speed", "mistake"), CASES, ids=[f"{m.name}-{k}-{'speed' if s else 'angle'}" for k, s, m in CASES]
)
def test_a_mistake_is_found_by_its_check_alone(kind: str, speed: bool, mistake: Mistake) -> None:
    log = right_log(kind)
    found = findings(record(mistake.make(log if speed else without_speed(log))), axis=AXES[kind])
    assert [(f.name, f.severity) for f in found.findings] == [(mistake.found, mistake.severity)]
    assert bool(found) is (mistake.severity != "fatal")


@pytest.mark.parametrize("kind", AXES)
@pytest.mark.parametrize("noise", [0.0, 0.005, 0.05])
def test_a_log_without_a_mistake_has_no_finding(kind: str, noise: float) -> None:
    assert findings(record(right_log(kind, noise=noise)), axis=AXES[kind]).findings == ()


def triangle() -> Array:
    t = np.arange(N) * H
    return np.asarray(5.0 * (2 / pi) * np.arcsin(np.sin(2 * pi * t / 3.0)))


def near_resonance() -> Array:
    """A speed that excites the joint about its antiresonance and resonance, 5.7 and 10 Hz, and nowhere else."""
    t = np.arange(N) * H
    lines = np.arange(34, 64)
    phases = np.random.default_rng(2).uniform(0, 2 * pi, len(lines))
    return np.asarray(2.0 * np.sin(2 * pi * np.outer(t / (N * H), lines) + phases).sum(axis=1))


def ringing(length: int) -> tuple[dict[str, float], Array]:
    """Parameters and speed, 2.5 s of all frequencies to 12 Hz, of a joint whose load swings at 3.5 Hz for long."""
    inertia, ratio, load, frequency, damping = 2e-3, 0.01, 4.7, 3.5356, 0.0016
    arm = load * inertia / ratio**2
    stiffness = arm * (2 * pi * frequency) ** 2
    truth = {
        "motor.inertia.J": inertia,
        "motor.viscous.Fv": 2e-4,
        "motor.coulomb.Fc": 0.02,
        "gear.spring.k1": stiffness,
        "gear.damper.d": 2 * damping * np.sqrt(stiffness * arm),
        "arm.inertia.J": arm,
    }
    lines = np.arange(1, 32)
    phases = np.random.default_rng(126).uniform(0, 2 * pi, len(lines))
    wave = np.sin(2 * pi * np.outer(np.arange(length) / length, lines) + phases).sum(axis=1)
    return truth, np.asarray(12.0 * wave / np.abs(wave).max())


PENDULUM = RIGID | {"motor.gravity.G": 1.5, "motor.gravity.H": 0.4}
LIGHT = RIGID | {"motor.viscous.Fv": 0.0, "motor.coulomb.Fc": 0.001}
OTHERS = {
    "pendulum": (PENDULUM, swing(), None),
    "slow triangle": (RIGID, triangle(), None),
    "slow triangle of a flexible joint": (FLEXIBLE, triangle(), RATIO),
    "near resonance": (FLEXIBLE, near_resonance(), RATIO),
    "hardly any friction": (LIGHT, swing(), None),
}


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_motions_that_are_hard_to_read_have_no_fatal_finding(name: str, seed: int) -> None:
    truth, reference, ratio = OTHERS[name]
    log = log_of(truth, reference * (1 + 0.1 * seed), ratio=ratio)
    assert findings(record(log), axis=Axis(ratio)).fatal == ()


def test_a_joint_that_rings_is_related_to_its_torque_and_not_to_another() -> None:
    truth, reference = ringing(1250)
    log = log_of(truth, reference, ratio=0.01, noise=0.001)
    axis = Axis(0.01)
    belongs = Evidence(record(log), inspect(record(log), "log"), axis).regression.relation
    assert belongs.explained > 0.98
    assert belongs.above_chance > 50.0
    assert findings(record(log), axis=axis).fatal == ()
    other = log_of(truth, reference[::-1].copy(), ratio=0.01, noise=0.001)
    found = findings(record(log | {"tau_m": other["tau_m"]}), axis=axis)
    assert [f.name for f in found.fatal] == ["torque_unrelated"]


def test_a_record_that_is_too_short_to_tell_is_not_refused_but_remarked() -> None:
    log = {name: values[:60] for name, values in right_log("rigid").items()}
    found = findings(record(log | {"tau_m": np.roll(log["tau_m"], 27)}))
    assert [f.severity for f in found.findings if f.name == "torque_unrelated"] == ["warning"]


@pytest.mark.parametrize("name", [name for name in OTHERS if name != "near resonance"])
def test_the_wrong_sign_of_the_torque_is_found_there_too(name: str) -> None:
    truth, reference, ratio = OTHERS[name]
    log = log_of(truth, reference, ratio=ratio)
    found = findings(record(log | {"tau_m": -log["tau_m"]}), axis=Axis(ratio))
    assert [f.name for f in found.fatal] == ["torque_sign"]


@pytest.mark.parametrize("name", ["smoke", "hidden", "demo", "paper"])
def test_the_shipped_configurations_have_no_warning(name: str) -> None:
    loaded = load(CONFIGS / f"{name}.yaml")
    config = loaded.config
    from robotid.signals.readers import read

    files = {r.name: read(loaded.directory / r.file) for r in config.records if r.file is not None}
    made = collect(config, excite(config), files)
    found = check_records(made, Axis(config.robot.gear_ratio, config.robot.linear))
    assert [f for f in found.findings if f.severity != "note"] == []


@pytest.mark.parametrize("seed", [3, 4, 5, 6])
def test_torque_and_angle_of_two_experiments_are_unrelated(seed: int) -> None:
    one, other = (log_of(RIGID, swing(seed=k) - swing(seed=k + 50)) for k in (10 + seed, 20 + seed))
    found = findings(record(one | {"tau_m": other["tau_m"]}))
    assert [f.name for f in found.fatal] == ["torque_unrelated"]


@pytest.mark.parametrize("samples", [100, -400])
def test_by_how_much_a_torque_is_of_another_time_is_measured(samples: int) -> None:
    log = right_log("rigid")
    found = Evidence(record(log | {"tau_m": np.roll(log["tau_m"], samples)}), inspect(record(log), "log"), Axis())
    assert found.torque_shifted is not None
    assert found.torque_shifted.shift == pytest.approx(samples * H, rel=0.01)


@pytest.mark.parametrize(
    ("factor", "meaning"),
    [
        (180 / pi, "degrees"),
        (30 / pi, "rpm"),
        (1 / (2 * pi), "revolutions"),
        (1e3, "milliseconds"),
        (3.3, "derivative"),
    ],
)
def test_the_factor_of_a_speed_is_recognised(factor: float, meaning: str) -> None:
    log = right_log("rigid")
    (found,) = findings(record(log | {"dphi_m": factor * log["dphi_m"]})).findings
    assert (found.name, found.severity) == ("speed_scale", "fatal")
    assert meaning in found.what


def test_the_speed_of_the_arm_is_recognised_by_the_gear_ratio() -> None:
    log = right_log("flexible")
    (found,) = findings(record(log | {"dphi_m": RATIO * log["dphi_m"]}), axis=Axis(RATIO)).findings
    assert "gear ratio" in found.what


def test_a_speed_that_is_hardly_off_is_a_warning() -> None:
    log = right_log("rigid")
    (found,) = findings(record(log | {"dphi_m": 1.08 * log["dphi_m"]})).findings
    assert (found.name, found.severity) == ("speed_scale", "warning")
    assert "1.08" in found.what


@pytest.mark.parametrize("samples", [2, -3])
def test_the_delay_of_a_speed_is_measured(samples: int) -> None:
    log = right_log("rigid")
    (found,) = findings(record(log | {"dphi_m": np.roll(log["dphi_m"], samples)})).findings
    assert found.name == "speed_delay"
    assert f"{abs(samples)}.0 samples {'late' if samples > 0 else 'early'}" in found.what
    assert f"speed_delay: {samples}" in found.cure


@pytest.mark.parametrize(("factor", "severity"), [(1.06, "warning"), (-1.0, "fatal"), (2.0, "fatal")])
def test_the_gear_ratio_is_compared_with_the_arms_encoder(factor: float, severity: str) -> None:
    one = record(right_log("flexible"))
    both = replace(one, phi_a=factor * RATIO * one.phi_m)
    (found,) = findings(both, axis=Axis(RATIO)).findings
    assert (found.name, found.severity) == ("gear_ratio", severity)


def test_a_right_gear_ratio_is_not_remarked() -> None:
    one = record(right_log("flexible"))
    assert findings(replace(one, phi_a=RATIO * one.phi_m), axis=Axis(RATIO)).findings == ()


def test_a_validation_record_that_repeats_the_fit_is_noted() -> None:
    one = record(right_log("rigid"))
    again = replace(record(log_of(RIGID, swing(), noise=0.01), "again").piece(200, N - 100), role="validate")
    other = replace(record(log_of(RIGID, swing(seed=5)), "other"), role="validate")
    found = findings(one, again, other)
    assert [(f.record, f.name, f.severity) for f in found.findings] == [("again", "repetition", "note")]


def test_flaws_of_the_recording_are_warnings() -> None:
    log = right_log("rigid")
    clipped = record(log | {"tau_m": np.clip(log["tau_m"], -0.7, 0.7)}, "clipped")
    coarse = Record.from_arrays(log["tau_m"], np.rint(log["phi_m"] * 16) / 16, H, name="coarse")
    resting = record({name: np.concatenate([np.repeat(v[:1], 2 * N), v]) for name, v in log.items()}, "resting")
    found = findings(clipped, coarse, resting)
    assert {(f.record, f.name) for f in found.findings} >= {
        ("clipped", "saturation"),
        ("coarse", "quantisation"),
        ("resting", "standstill"),
    }
    assert found.fatal == ()


def test_a_motion_without_reversal_is_noted() -> None:
    log = log_of(RIGID, 30.0 + 0.5 * swing() * (np.arange(N) > 300))
    assert "reversals" in {f.name for f in findings(record(log)).findings}


def test_jitter_and_gaps_come_with_their_cost() -> None:
    one = record(right_log("rigid"))
    report = replace(inspect(one, "log"), jitter=0.5, jitter_rms=0.1, missing=30)
    found = check_records(Recordings((one,), (report,)), Axis())
    gaps, jitter = found.named("clock")
    assert "10 % RMS" in jitter.what
    assert jitter.severity == "note"
    assert "rad/s of noise" in jitter.consequence
    worse = check_records(Recordings((one,), (replace(report, jitter_rms=0.4, missing=0),)), Axis())
    assert [f.severity for f in worse.named("clock")] == ["warning"]
    assert gaps.what == "30 of 3000 samples were missing and are filled in"


def test_an_accepted_mistake_stops_nothing() -> None:
    log = right_log("rigid")
    wrong = record(log | {"tau_m": -log["tau_m"]})
    found = findings(wrong, accepted=("torque_sign",))
    assert bool(found)
    assert [f.accepted for f in found.findings] == [True]
    refuse_meaningless(found, "robotid check", "{name}")


def test_the_refusal_is_one_line_with_number_consequence_and_cure() -> None:
    log = right_log("rigid")
    wrong = log | {"tau_m": -log["tau_m"]}
    with pytest.raises(NumericsError) as error:
        refuse_meaningless(findings(record(wrong, "a"), record(wrong, "b")), "robotid check", "accept {name}")
    line = str(error.value)
    assert line.startswith("a: torque and motion ask for an inertia of -0.012")
    assert "(b alike)" in line
    assert "scale: -1" in line
    assert "accept torque_sign accepts it" in line
    assert "\n" not in line


def test_every_check_says_what_it_asks_and_waits_for_checks_that_exist() -> None:
    asked: set[str] = set()
    for name, check in CHECKS.items():
        assert check.summary.endswith(".")
        assert set(check.unless) <= asked
        asked.add(name)
    assert {mistake.found for mistake in MISTAKES} <= asked


def test_findings_are_ordered_by_gravity() -> None:
    log = right_log("rigid")
    found = findings(
        record(log | {"dphi_m": 1.08 * log["dphi_m"]}, "first"), record(log | {"tau_m": -log["tau_m"]}, "second")
    )
    assert [f.severity for f in found.findings] == ["fatal", "warning"]
    assert all(isinstance(f, Finding) for f in found.findings)
