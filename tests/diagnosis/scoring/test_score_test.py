"""The score of a candidate: what it promises is what a refit removes, and noise alone is seldom taken for an effect."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import sosfilt
from scipy.stats import binom
from support.noise import speed_whitening
from support.small_bench import AXIS, fitted, records

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, extended
from robotid.diagnosis.scoring.candidate import EffectCandidate
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.diagnosis.scoring.projection import Projected, project
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.diagnosis.scoring.score_test import Score, _place, score, significance
from robotid.estimate.fitted_model import fitted_model
from robotid.model.array import Array
from robotid.signals.record import Record

SPEED, TORQUE = 0.01, 0.005  # standard deviations of the noise that the score counts in [rad/s, Nm]
LEVEL, SEEDS = 0.01, 1000
ATTEMPTS = {
    "motor.stribeck": ({"dFs": 2e-3}, {"vs": 1.0}),
    "motor.cogging": ({"A": 1e-3, "B": -5e-4}, {"n": 6.0}),
    "motor.position_friction": ({"A": 1e-3, "B": 1e-3}, {"n": 2.0}),
    "motor.quadratic_friction": ({"Fq": 2e-5}, {}),
    "motor.asymmetric_viscous": ({"dFv": 2e-5}, {}),
    "motor.thermal_friction": ({"c": 1e-2}, {"T": 1.0}),
    "torque.torque_lag": ({"T": 2e-5}, {}),
    "torque.torque_saturation": ({"c": 1e-3}, {}),
    "angle.encoder_ripple": ({"A": 3e-4, "B": 3e-4}, {"n": 3.0}),
}
"""Small amplitudes, and shapes on the grid, by effect."""


def unfit(made: list[Record]) -> tuple[EvaluationData, RefittedModel]:
    """The axis without the effect on noise-free records, and the whitening of a noise that is not there."""
    fit = fitted_model(fitted(made))
    variances = (SPEED**2, TORQUE**2)
    segments = tuple(Segment(r, speed_whitening(fit.joint, fit.theta, r.sampling_time, variances)) for r in made[:2])
    data = EvaluationData(segments, (), "speed", estimate_states=True, noise_reached=True, torque_errors=None)
    return data, refit(AXIS, [fit.parameters], data)


def at(name: str, shapes: dict[str, float]) -> EffectCandidate:
    """A candidate at a point of its grid."""
    for c in candidates(AXIS, "speed"):
        known = {p.symbol: v for p, v in zip(c.parameters, c.values, strict=True) if p.is_shape}
        if c.name == name and known == shapes:
            return c
    raise AssertionError(f"{name} is not scored at {shapes}")


@pytest.mark.parametrize("name", ATTEMPTS)
def test_the_energy_that_a_score_promises_is_what_a_refit_removes(name: str) -> None:
    amplitudes, shapes = ATTEMPTS[name]
    c = at(name, shapes)
    made = records({f"{name}.{symbol}": value for symbol, value in (amplitudes | shapes).items()}, quiet=True)
    data, before = unfit(made)
    (promised,) = score(project(scans(before.fitted, before.unknowns, (c,))), (c,))
    assert promised.energy > 1.0
    found = dict(zip(amplitudes, promised.amplitude, strict=True))
    for symbol, value in amplitudes.items():
        assert found[symbol] == pytest.approx(value, abs=0.1 * max(map(abs, amplitudes.values())))
    structure, start = extended(before, name, {f"{name}.{s}": v for s, v in (shapes | found).items()})
    held = np.array([p not in {f"{name}.{s}" for s in shapes} for p in start.names])
    after = refit(structure, [replace(start, free=held)], data, before.trajectories)
    assert before.energy - after.energy == pytest.approx(promised.energy, rel=0.1)
    assert after.energy < 0.05 * before.energy


@cache
def columns() -> tuple[tuple[EffectCandidate, ...], tuple[Scan, ...]]:
    """The whole catalogue on the records of an axis that lacks nothing."""
    missing = candidates(AXIS, "speed")
    _, model = unfit(records({}, quiet=True))
    return missing, scans(model.fitted, model.unknowns, missing)


def inverse(sections: Array) -> Array:
    """The filter that undoes one in second-order sections."""
    return np.hstack([sections[:, 3:], sections[:, :3]]) / sections[:, :1]


def noises(count: int) -> tuple[Projected, Array]:
    """The catalogue beside nothing, and pure noise of speed and torque, (d, count), as the search sees both."""
    missing, scanned = columns()
    rng, several = np.random.default_rng(11), []
    for one in scanned:
        white = rng.standard_normal((count, len(one.segment.record)))
        shaped = sosfilt(inverse(one.whitening.sections), white, axis=1)
        several.append(replace(one, signals=np.concatenate([one.signals[:-1], shaped, 0.0 * one.signals[-1:]])))
    both, q = project(several), sum(len(c.scored) for c in missing)
    return replace(both, missing=both.missing[:, :q], whole=both.whole[:, :q]), both.missing[:, q:]


def every_score(seen: Projected, noise: Array) -> list[Score]:
    """The directions of all candidates that the data show, whichever sign the noise may give them."""
    missing = columns()[0]
    both = [score(replace(seen, residual=sign * noise), missing) for sign in (1.0, -1.0)]
    return list({id(s.candidate): s for scores in both for s in scores if s.directions.size}.values())


def false_alarms(seen: Projected, noise: Array, tries: int) -> int:
    """How many draws of noise hold an effect that is significant."""
    found = every_score(seen, noise[:, 0])
    samples, total = sum(len(one.segment.record) for one in columns()[1]), np.sum(noise**2, axis=0)
    p = np.ones(noise.shape[1])
    for k in {s.directions.shape[1] for s in found}:
        own = [s.directions for s in found if s.directions.shape[1] == k]
        best = np.max([np.sum((d.T @ noise) ** 2, axis=0) for d in own], axis=0)
        chances = [significance(e, k, t, samples, tries) for e, t in zip(best.tolist(), total.tolist(), strict=True)]
        p = np.minimum(p, chances)
    return int(np.sum(p < LEVEL))


def test_noise_alone_is_taken_for_an_effect_no_more_often_than_the_level_allows() -> None:
    seen, noise = noises(SEEDS)
    missing = columns()[0]
    assert false_alarms(seen, noise, len(missing)) <= binom.ppf(0.999, SEEDS, LEVEL)
    assert false_alarms(seen, noise, 1) > 5 * binom.ppf(0.999, SEEDS, LEVEL)  # but for the allowance for many tries


def test_the_noise_that_a_score_counts_in_has_one_unit_of_energy_a_direction() -> None:
    seen, noise = noises(SEEDS)
    for one in every_score(seen, noise[:, 0]):
        k = one.directions.shape[1]
        energy = np.sum((one.directions.T @ noise) ** 2, axis=0)
        assert np.mean(energy) == pytest.approx(k, abs=5 * np.sqrt(2 * k / SEEDS))


def test_a_faint_effect_is_significant() -> None:
    """Nine standard deviations stand out of so many tries, and five do; three do not."""
    seen, noise = noises(SEEDS)
    one = next(s for s in every_score(seen, noise[:, 0]) if s.candidate.name == "motor.quadratic_friction")
    total, tries = float(np.sum(noise[:, 0] ** 2)), len(columns()[0])
    samples = sum(len(s.segment.record) for s in columns()[1])
    assert one.directions.shape[1] == 1
    assert significance(81.0, 1, total + 81.0, samples, tries) < 1e-12
    assert significance(25.0, 1, total + 25.0, samples, tries) < LEVEL
    assert significance(9.0, 1, total + 9.0, samples, tries) > LEVEL


def test_of_laws_that_are_one_on_these_motions_the_simpler_comes_first() -> None:
    known = {one.name: one for one in candidates(AXIS, "speed")}
    nothing = np.zeros(0)
    cogging = Score(known["motor.cogging"], 1000.0 * (1.0 + 1e-12), (1.0, 0.0), nothing, nothing)
    gravity = Score(known["motor.gravity"], 1000.0, (1.0, 0.0), nothing, nothing)
    assert sorted([cogging, gravity], key=_place) == [gravity, cogging]
    better = replace(cogging, energy=1001.0)
    assert sorted([gravity, better], key=_place) == [better, gravity]
