"""Linear regression of the rigid joint: known answers, excuses, and a real machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import loadmat
from support.paths import SHARED
from support.small_bench import AXIS, records_of
from support.small_bench import TRUTH as AXIS_TRUTH

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate.regressor import FilteredRecord
from robotid.estimate.rigid import RigidResult, fit_rigid, fit_rigid_on, torque_error
from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure
from robotid.signals.companion import Companion
from robotid.signals.differentiate import ParallelFilter
from robotid.signals.record import Record

EMPS = SHARED / "emps" / "DATA_EMPS.mat"
H = 1e-3
T = np.arange(20_000) * H
R = 0.01
FRICTION = ("motor.inertia", "motor.viscous", "motor.coulomb")
ARM = (*FRICTION, "gear.spring", "arm.inertia", "arm.viscous", "arm.gravity")
TRUTH = {
    "motor.inertia.J": 0.02,
    "motor.viscous.Fv": 0.03,
    "motor.coulomb.Fc": 0.5,
    "gear.spring.k1": 1e6,
    "arm.inertia.J": 150.0,
    "arm.viscous.Fv": 100.0,
    "arm.gravity.G": 80.0,
    "arm.gravity.H": 40.0,
}


def motion() -> tuple[Array, Array, Array]:
    """Angle, speed and acceleration of a slow and a faster sine."""
    x, v, a = np.zeros((3, len(T)))
    for amplitude, omega, phase in ((150.0, 0.7, 0.1), (8.0, 5.0, 1.0), (1.5, 11.0, 2.0)):
        x += amplitude * np.sin(omega * T + phase)
        v += amplitude * omega * np.cos(omega * T + phase)
        a -= amplitude * omega**2 * np.sin(omega * T + phase)
    return x, v, a


def rigid_record(noise: float = 0.0, seed: int = 0, name: str = "r") -> Record:
    """What a perfectly rigid joint with TRUTH would record."""
    x, v, a = motion()
    J, Fv = (TRUTH[f"motor.{s}"] + R**2 * TRUTH[f"arm.{s}"] for s in ("inertia.J", "viscous.Fv"))
    gravity = R * (TRUTH["arm.gravity.G"] * np.sin(R * x) + TRUTH["arm.gravity.H"] * np.cos(R * x))
    tau = J * a + Fv * v + TRUTH["motor.coulomb.Fc"] * np.sign(v) + gravity
    tau = tau + noise * np.random.default_rng(seed).standard_normal(len(T))
    return Record(name, "estimate", "rigid", H, tau, x, v)


def fit(
    terms: tuple[str, ...], *records: Record, fixed: Mapping[str, float] | None = None, cutoff: float | None = 20.0
) -> RigidResult:
    joint = assemble(Structure(terms, gear_ratio=None if terms[-1].startswith("motor") else R))
    return fit_rigid(joint, hold(joint.parameters(), fixed or {}), records, ParallelFilter(cutoff))


def hold(parameters: Parameters, fixed: Mapping[str, float]) -> Parameters:
    free = np.array([name not in fixed for name in parameters.names])
    return replace(parameters.with_values(fixed), free=free)


def test_exact_parameters_from_noiseless_data() -> None:
    result = fit(ARM, rigid_record())
    assert result["joint.inertia.J"].value == pytest.approx(0.02 + R**2 * 150, rel=1e-3)
    assert result["joint.viscous.Fv"].value == pytest.approx(0.03 + R**2 * 100, rel=2e-3)
    assert result["motor.coulomb.Fc"].value == pytest.approx(0.5, rel=2e-3)
    assert result["arm.gravity.G"].value == pytest.approx(80, rel=5e-3)
    assert result["arm.gravity.H"].value == pytest.approx(40, rel=5e-3)
    assert result.torque_error_percent["r"] < 0.3
    assert 1 < result.condition_number < 100


def test_bristles_take_the_place_of_dry_friction_at_their_port() -> None:
    s0, s1, terms = 400.0, 6e-4, (*FRICTION, "motor.presliding")
    x, v, a = (1e-3 * signal for signal in motion())
    z = bristles(s0, v)
    tau = 0.02 * a + 0.03 * v + 0.037 * (z + s1 * s0 * (v - np.abs(v) * z))
    record = Record("r", "estimate", "rigid", H, tau, x, v)
    known = {"motor.presliding.w": 1.0, "motor.presliding.s0": s0, "motor.presliding.s1": s1}
    found, without = fit(terms, record, fixed=known), fit(FRICTION, record)
    assert found["motor.inertia.J"].value == pytest.approx(0.02, rel=0.01)
    assert found["motor.viscous.Fv"].value == pytest.approx(0.03, rel=0.02)
    assert found["motor.coulomb.Fc"].value == pytest.approx(0.037, rel=0.005)
    assert 20.0 * found.torque_error_percent["r"] < without.torque_error_percent["r"]


def bristles(s0: float, v: Array) -> Array:
    """Deflection of bristles in parts of that at which they slip, settled at first: dz/dt = s0 (v - |v| z), exactly
    for a speed that stays as it is over each interval."""
    z = np.full(len(v), np.sign(v[0]))
    for k, speed in enumerate(v[:-1]):
        z[k + 1] = np.sign(speed) + (z[k] - np.sign(speed)) * np.exp(-s0 * abs(speed) * H)
    return z


def test_a_regression_with_bristles_is_that_of_these_bristles() -> None:
    """What a record keeps of one regression does not serve another with stiffer bristles."""
    x, v, _ = (1e-3 * signal for signal in motion())
    terms, sliding = (*FRICTION, "motor.presliding"), Record("r", "estimate", "rigid", H, bristles(400.0, v), x, v)
    joint, kept = assemble(Structure(terms, gear_ratio=None)), FilteredRecord(sliding, ParallelFilter(20.0))

    def error(s0: float) -> float:
        known = {"motor.presliding.w": 1.0, "motor.presliding.s0": s0, "motor.presliding.s1": 0.0}
        return fit_rigid_on([kept], joint, hold(joint.parameters(), known)).torque_error_percent["r"]

    assert error(4000.0) > 20.0 * error(400.0)


def test_what_acts_together_is_one_sum_on_the_motor_side() -> None:
    result = fit(ARM, rigid_record())
    assert [p.name for p in result.parameters][:2] == ["joint.inertia.J", "joint.viscous.Fv"]
    assert "motor.inertia.J, arm.inertia.J" in result["joint.inertia.J"].remark
    assert result.guesses["motor.inertia.J"] + R**2 * result.guesses["arm.inertia.J"] == pytest.approx(
        result["joint.inertia.J"].value
    )
    assert result.guesses["motor.viscous.Fv"] == result["joint.viscous.Fv"].value
    assert result.guesses["arm.viscous.Fv"] == 0.0
    assert "gear.spring.k1" in result.remarks[0]
    assert "gear.spring.k1" not in result.guesses


def test_a_held_parameter_keeps_its_value() -> None:
    held = {"motor.inertia.J": 0.02, "motor.viscous.Fv": 0.03, "motor.coulomb.Fc": 0.5}
    result = fit(ARM, rigid_record(), fixed=held)
    assert [p.name for p in result.parameters] == [
        "arm.inertia.J",
        "arm.viscous.Fv",
        "arm.gravity.G",
        "arm.gravity.H",
    ]
    assert result["arm.inertia.J"].value == pytest.approx(150, rel=5e-3)


def test_nothing_left_to_estimate() -> None:
    held = {"motor.inertia.J": 0.035, "motor.viscous.Fv": 0.04, "motor.coulomb.Fc": 0.5}
    result = fit(FRICTION, rigid_record(), fixed=held)
    assert result.parameters == ()
    assert "fixed" in result.remarks[0]


def test_standard_deviations_are_those_of_repeated_experiments() -> None:
    results = [fit(ARM, rigid_record(noise=0.3, seed=k)) for k in range(25)]
    for name in ("joint.inertia.J", "joint.viscous.Fv", "motor.coulomb.Fc"):
        spread = np.std([r[name].value for r in results], ddof=1)
        for key in ("std", "std_robust"):
            assert 0.5 < np.mean([getattr(r[name], key) for r in results]) / spread < 2.0


def test_a_poor_record_does_not_spoil_a_good_one() -> None:
    good, poor = rigid_record(0.01, 1, "good"), rigid_record(0.0, 2, "poor")
    poor = replace(poor, tau_m=1.5 * poor.tau_m + 3 * np.sin(2 * np.pi * 1.3 * T))
    result = fit(ARM, good, poor)
    assert result["joint.inertia.J"].value == pytest.approx(0.035, rel=0.01)
    assert result.torque_error_percent["poor"] > 10 * result.torque_error_percent["good"]


def test_a_parameter_that_is_nothing_is_said() -> None:
    result = fit((*FRICTION, "motor.constant_torque"), without_gravity())
    assert "not distinct from zero" in result["motor.constant_torque.tau0"].remark
    assert result["motor.coulomb.Fc"].remark == ""


def without_gravity(noise: float = 0.3) -> Record:
    record = rigid_record(noise)
    gravity = R * (80 * np.sin(R * record.phi_m) + 40 * np.cos(R * record.phi_m))
    return replace(record, tau_m=record.tau_m - gravity)


def test_slow_samples_may_be_left_out() -> None:
    joint = assemble(Structure(FRICTION))
    stuck = without_gravity(noise=0.0)
    slow = np.abs(stuck.dphi_m) < 15.0
    stuck = replace(stuck, tau_m=np.where(slow, stuck.tau_m + 0.3, stuck.tau_m))
    with_slow, without = (
        fit_rigid(joint, joint.parameters(), [stuck], ParallelFilter(100.0, min_speed=s))["motor.coulomb.Fc"].value
        for s in (0.0, 20.0)
    )
    assert abs(without - 0.5) < 0.02
    assert abs(without - 0.5) < abs(with_slow - 0.5)


def test_collinear_effects_are_named() -> None:
    terms = (*FRICTION, "motor.constant_torque", "motor.asymmetric_coulomb")
    with pytest.raises(
        NumericsError, match=r"cannot tell motor\.constant_torque\.tau0 from motor\.asymmetric_coulomb\.dFc"
    ):
        fit(terms, rigid_record())


def test_one_way_motion_cannot_tell_coulomb_friction() -> None:
    record = without_gravity(noise=0.0)
    record = replace(record, phi_m=record.phi_m + 300 * T, tau_m=record.tau_m + 0.04 * 300)
    with pytest.raises(NumericsError, match=r"cannot tell motor\.coulomb\.Fc from motor\.constant_torque\.tau0"):
        fit((*FRICTION, "motor.constant_torque"), record)


def test_a_motor_at_rest_excites_nothing() -> None:
    record = rigid_record()
    with pytest.raises(NumericsError, match=r"do not excite motor\.inertia\.J, motor\.viscous\.Fv, motor\.coulomb\.Fc"):
        fit(FRICTION, replace(record, phi_m=0 * T))


def test_a_constant_torque_excites_nothing() -> None:
    with pytest.raises(NumericsError, match="r: the torque is constant"):
        fit(FRICTION, replace(rigid_record(), tau_m=1.0 + 0 * T), cutoff=None)


def test_a_short_record_is_refused() -> None:
    record = rigid_record()
    cut = replace(record, tau_m=record.tau_m[:300], phi_m=record.phi_m[:300], dphi_m=record.dphi_m[:300])
    with pytest.raises(NumericsError, match="too few for 3 parameters"):
        fit(FRICTION, cut, cutoff=5.0)


def test_of_a_slow_record_enough_is_left_to_fit_a_flexible_joint() -> None:
    """Nearly all of the torque lies below a frequency at which next to nothing of the record is left."""
    record = rigid_record()
    slow = replace(record, tau_m=record.tau_m + 100 * np.sin(0.7 * T))
    result = fit(ARM, slow, cutoff=None)
    assert result.cutoff["r"] >= 10 / slow.duration


def test_no_record_is_refused() -> None:
    with pytest.raises(NumericsError, match="no record serves the rigid initialisation"):
        fit(FRICTION)


@pytest.fixture(scope="module")
def emps() -> Record:
    """The real linear axis, read by hand."""
    if not EMPS.exists():
        pytest.skip(f"the measured records are not here: {EMPS.parent}")
    data = loadmat(EMPS)
    q, force = data["qm"].ravel(), 35.1507 * data["vir"].ravel()
    return Record("emps", "estimate", "both", H, force, q, np.gradient(q, H))


def fit_emps(emps: Record, *more: str, cutoff: float | None = None) -> RigidResult:
    joint = assemble(Structure((*FRICTION, *(f"motor.{name}" for name in more)), linear=True))
    return fit_rigid(joint, joint.parameters(), [emps], ParallelFilter(cutoff))


@pytest.mark.parametrize("cutoff", [None, 20.0, 40.0])
def test_emps_as_published(emps: Record, cutoff: float | None) -> None:
    result = fit_emps(emps, "constant_torque", cutoff=cutoff)
    assert result["motor.inertia.J"].value == pytest.approx(95.11, rel=0.01)
    assert result["motor.viscous.Fv"].value == pytest.approx(203.5, rel=0.01)
    assert result["motor.coulomb.Fc"].value == pytest.approx(20.39, rel=0.01)
    assert result["motor.constant_torque.tau0"].value == pytest.approx(-3.165, rel=0.03)
    assert result.torque_error_percent["emps"] <= 4.1


def test_emps_with_friction_by_direction(emps: Record) -> None:
    result = fit_emps(emps, "asymmetric_viscous", "asymmetric_coulomb")
    Fv, dFv = (result[f"motor.{n}"].value for n in ("viscous.Fv", "asymmetric_viscous.dFv"))
    Fc, dFc = (result[f"motor.{n}"].value for n in ("coulomb.Fc", "asymmetric_coulomb.dFc"))
    assert result["motor.inertia.J"].value == pytest.approx(95.15, rel=0.01)
    assert (Fv + dFv, Fv - dFv) == pytest.approx((166.7, 240.4), rel=0.01)
    assert (Fc + dFc, Fc - dFc) == pytest.approx((20.14, 20.63), rel=0.01)
    assert result.torque_error_percent["emps"] <= 3.2


def test_what_another_axis_changes_starts_only_where_it_is_seen() -> None:
    """Another axis that hardly moves tells no inertia, and what least squares then makes of the noise is no start."""
    joint = assemble(Structure((*FRICTION, "motor.pose_inertia[q2]")))
    parts = {"motor.pose_inertia[q2].A", "motor.pose_inertia[q2].B"}
    for size in (0.2, 1.0):
        angle = Companion.of(CompanionKind.ANGLE, 1.0 + size * np.sin(1.3 * T), H)
        record = replace(rigid_record(3.0), companions={"q2": angle})
        found = fit_rigid(joint.along(record), joint.parameters(), [record], ParallelFilter(10.0))
        assert {p.name for p in found.parameters} >= parts
        distinct = {name for name in parts if abs(found[name].value) >= 2 * found[name].std_robust}
        assert parts & set(found.guesses) == distinct
        assert "motor.inertia.J" in found.guesses


def test_models_on_the_same_records_share_what_is_filtered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each comes out as by itself, and of the second only its further column is filtered."""
    record, parallel = rigid_record(noise=0.01), ParallelFilter(20.0)
    models = [assemble(Structure(FRICTION)), assemble(Structure((*FRICTION, "motor.constant_torque")))]
    alone = [fit_rigid(joint, joint.parameters(), [record], parallel) for joint in models]
    filtered, counts = FilteredRecord(record, parallel), []
    apply = ParallelFilter.apply

    def counted(self: ParallelFilter, signals: Array, sampling_time: float) -> Array:
        counts[-1] += 1
        return apply(self, signals, sampling_time)

    monkeypatch.setattr(ParallelFilter, "apply", counted)
    for joint, one in zip(models, alone, strict=True):
        counts.append(0)
        found = fit_rigid_on([filtered], joint, joint.parameters())
        assert found.guesses == one.guesses
        assert found.torque_error_percent == one.torque_error_percent
        assert found.cutoff == one.cutoff
    assert counts == [6, 1]


def test_a_model_with_another_known_torque_is_filtered_anew() -> None:
    record, parallel = rigid_record(), ParallelFilter(20.0)
    joint = assemble(Structure(FRICTION))
    filtered = FilteredRecord(record, parallel)
    for Fc in (0.5, 0.1):
        parameters = hold(joint.parameters(), {"motor.coulomb.Fc": Fc})
        found, one = fit_rigid_on([filtered], joint, parameters), fit_rigid(joint, parameters, [record], parallel)
        assert found.guesses == one.guesses


def test_what_there_is_no_room_for_is_filtered_again(monkeypatch: pytest.MonkeyPatch) -> None:
    record, parallel = rigid_record(), ParallelFilter(20.0)
    joint = assemble(Structure(FRICTION))
    alone, filtered = fit_rigid(joint, joint.parameters(), [record], parallel), FilteredRecord(record, parallel)
    monkeypatch.setattr("robotid.estimate.regressor.MAX_KEPT_COLUMNS", 2 * len(record))
    for _ in range(2):
        assert fit_rigid_on([filtered], joint, joint.parameters()).guesses == alone.guesses
        assert len(filtered.columns) == 2


def test_the_torque_of_a_record_is_that_of_its_own_parameters() -> None:
    """With an inertia that is half as large again in one of them."""
    heavier = 0.5 * AXIS_TRUTH["motor.inertia.J"]
    truth = AXIS_TRUTH | {"motor.inertia.J": AXIS_TRUTH["motor.inertia.J"] + heavier}
    wide = records_of(assemble(AXIS, angle=True), truth)[1]
    joint = assemble(AXIS.extended("record_change.wide.motor.inertia.J"))
    known = joint.parameters().with_values(AXIS_TRUTH | {"record_change.wide.motor.inertia.J": heavier})
    own, other = (torque_error(joint, known, one, ParallelFilter(30.0)) for one in (wide, replace(wide, name="other")))
    assert own < 5.0
    assert other > 4.0 * own
