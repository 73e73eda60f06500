"""What records tell of parameters, and the reasons in words."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.judged_records import clean_records, model
from support.paper_joint import STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.estimate.fitted_model import simulate_record
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.result import End, Estimate, FitResult
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate
from robotid.validation.identifiability import column_cosines, correlations, identify
from robotid.validation.results import Identifiability
from robotid.validation.torque_share import TorqueShare, torque_shares

SHARES = {"motor.viscous": TorqueShare("motor.viscous", "motor", 0.3, 0.5, "a speed of 40 rad/s on set1", False)}


def result(
    value: float, std: float, remark: str = "", covariance: Array | None = None, fixed: bool = False
) -> FitResult:
    names = ("motor.viscous.Fv", "motor.coulomb.Fc")
    parameters = tuple(Estimate(name, value, "Nm", std, std, 0.0, 1e6, fixed, remark) for name in names)
    covariance = std**2 * np.eye(2) if covariance is None else covariance
    return FitResult(
        "m", ("set1",), "speed", Structure(("motor.viscous", "motor.coulomb")), parameters, covariance, covariance,
        {}, {}, {}, np.ones(1), 1, End.CONVERGED, 0.1,
    )  # fmt: skip


def first(fit: FitResult, share: float = 0.3) -> Identifiability:
    return identify(fit, {"motor.viscous": replace(SHARES["motor.viscous"], rms=share)})[0]


@pytest.mark.parametrize(
    ("fit", "share", "verdict", "words"),
    [
        (result(1.0, 0.01), 0.3, "seen", "standard deviation 1 % of its value"),
        (result(1.0, 0.2), 0.3, "weak", "standard deviation 20 % of its value"),
        (result(1.0, 0.6), 0.3, "unseen", "not distinct from zero"),
        (result(0.0, 0.6), 0.3, "unseen", "not distinct from zero"),
        (result(1.0, 0.01), 0.03, "weak", "carries 3 % of the torque at the motor (RMS), 50 % where it is largest"),
        (result(1.0, 0.01), 0.005, "unseen", "against noise alone its standard deviation is 1 %"),
        (result(1.0, 0.01, "at its upper bound"), 0.3, "weak", "at its upper bound"),
        (result(1.0, 0.01, "unidentifiable on these records"), 0.3, "unseen", "unidentifiable on these records"),
        (result(1.0, 0.01, "fixed", fixed=True), 0.3, "fixed", "not estimated"),
        (
            result(1.0, 0.01, covariance=1e-4 * np.array([[1.0, -0.9999], [-0.9999, 1.0]])),
            0.3,
            "weak",
            "least from motor.coulomb.Fc (correlation -1.000)",
        ),
    ],
)
def test_verdicts(fit: FitResult, share: float, verdict: str, words: str) -> None:
    judged = first(fit, share)
    assert judged.verdict == verdict
    assert words in judged.why


def test_cosine_from_the_covariance_is_that_of_the_columns() -> None:
    rng = np.random.default_rng(1)
    columns = rng.standard_normal((4, 300)) * np.array([[1.0], [1e3], [1e-4], [1.0]])
    columns[3] += 3 * columns[0]
    q = np.linalg.qr(columns[:3].T)[0]
    expected = np.linalg.norm(q.T @ columns[3]) / np.linalg.norm(columns[3])
    covariance = np.zeros((5, 5))
    covariance[:4, :4] = np.linalg.inv(columns @ columns.T)
    assert column_cosines(covariance)[3] == pytest.approx(expected)
    assert column_cosines(covariance)[4] == 0.0  # not estimated
    assert np.diag(correlations(covariance)).tolist() == pytest.approx([1, 1, 1, 1, 0])


@cache
def fitted(amplitude: float) -> tuple[FitResult, dict[str, TorqueShare]]:
    """The paper's joint fitted to its own noisy response to a torque of this size [Nm]."""
    joint, rng = assemble(STRUCTURE), np.random.default_rng(2)
    parameters = joint.parameters().with_values(TRUTH)
    torque = amplitude * clean_records()[0].tau_m
    record = replace(clean_records()[0], tau_m=torque)
    motion = simulate(joint, parameters.values, record, np.zeros(joint.nx))
    noisy = replace(record, dphi_m=motion.dphi_m + 0.01 * rng.standard_normal(len(record)), phi_m=motion.phi_m)
    fit = fit_model("m", joint, parameters, (noisy,), FitOptions())
    return fit, torque_shares([(record.name, simulate(joint, parameters.values, noisy))])


def verdict(amplitude: float, name: str) -> Identifiability:
    return next(i for i in identify(*fitted(amplitude)) if i.name == name)


def test_the_cubic_spring_is_unseen_on_small_twists() -> None:
    judged = verdict(1.0, "gear.cubic_spring.k3")
    assert judged.verdict == "unseen"
    assert "gear.cubic_spring carries" in judged.why
    assert "of the torque at the gear (RMS)" in judged.why
    assert "a twist of" in judged.why
    assert verdict(1.0, "gear.spring.k1").verdict == "seen"


def test_the_cubic_spring_is_seen_on_large_twists() -> None:
    judged = verdict(20.0, "gear.cubic_spring.k3")
    assert judged.verdict == "seen"
    assert judged.torque_share is not None
    assert judged.torque_share > 0.05


def test_shares_by_hand() -> None:
    record: Record = clean_records()[0]
    trajectory = simulate_record(model({}), record).trajectories[0]
    twist, slip = trajectory.x[0], trajectory.joint.ratio * trajectory.x[1] - trajectory.x[2]
    spring, cubic, damper = (
        TRUTH["gear.spring.k1"] * twist,
        TRUTH["gear.cubic_spring.k3"] * twist**3,
        TRUTH["gear.damper.d"] * slip,
    )
    total = np.abs(spring) + np.abs(cubic) + np.abs(damper)
    found = torque_shares([(record.name, trajectory)])
    share = found["gear.cubic_spring"]
    assert share.rms == pytest.approx(np.linalg.norm(cubic) / np.linalg.norm(total))
    at = np.argmax(np.abs(twist))
    assert share.largest == pytest.approx(abs(cubic[at]) / total[at])
    assert share.there == f"a twist of {abs(twist[at]):.3g} rad on small"
    assert found["motor.viscous"].there.endswith("rad/s on small")
    assert found["arm.inertia"].alone
    assert found["arm.inertia"].rms == pytest.approx(1.0)


def test_what_bends_the_motion_is_judged_without_a_torque_of_its_own() -> None:
    record = clean_records()[0]
    bent, plain = (assemble(s) for s in (replace(STRUCTURE, terms=(*STRUCTURE.terms, "gear.backlash")), STRUCTURE))
    values = bent.parameters().with_values(TRUTH | {"gear.backlash.gap": 1e-6}).values
    found = torque_shares([(record.name, simulate(bent, values, record))])
    assert list(found) == list(torque_shares([(record.name, simulate(plain, values[: len(plain.names)], record))]))
