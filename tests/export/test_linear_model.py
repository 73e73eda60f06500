"""The exported matrices answer as the linearised joint does, whatever its make-up."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat
from support.paper_joint import STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.estimate.result import End, Estimate, FitResult
from robotid.export.linear_model import model_tree
from robotid.export.write import write_tree
from robotid.model.array import Array
from robotid.model.linear import LinearJoint, linearise
from robotid.model.structure import Structure

OMEGA = 2 * np.pi * np.geomspace(0.3, 200, 60)
RIGID = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
TOOL = Structure((*STRUCTURE.terms, "link.third_mass"), gear_ratio=STRUCTURE.gear_ratio)
THREE = Structure((*STRUCTURE.terms, "link.spring", "link.damper", "tool.inertia"), gear_ratio=STRUCTURE.gear_ratio)


def fit_of(structure: Structure, values: dict[str, float]) -> FitResult:
    """A fit with these values, or the declared guesses."""
    p = assemble(structure).parameters().with_values(values)
    estimates = tuple(
        Estimate(name, float(value), unit, 0.1, 0.2, float(low), float(high))
        for name, value, unit, low, high in zip(p.names, p.values, p.units, p.lower, p.upper, strict=True)
    )
    zero = np.zeros((len(p.names),) * 2)
    return FitResult(
        "m", ("a",), "speed", structure, estimates, zero, zero, {}, {}, {"a": 99.0}, np.ones(1), 3, End.CONVERGED, 1.0
    )


def linear_of(structure: Structure, fit: FitResult, speed: float) -> LinearJoint:
    return linearise(assemble(structure), np.array([p.value for p in fit.parameters]), speed)


def answer(m: dict[str, Array], output: str) -> Array:
    """Response of the exported state space from torque to an output, (n,)."""
    row = [name.strip() for name in m["output_names"]].index(output)
    s = 1j * OMEGA[:, None, None]
    states = np.linalg.solve(s * np.eye(len(m["A"])) - m["A"], np.broadcast_to(m["B"], (len(OMEGA), *m["B"].shape)))
    return np.asarray((m["C"][row] @ states + m["D"][row])[:, 0])


@pytest.mark.parametrize(
    ("structure", "values", "speed"),
    [
        (STRUCTURE, TRUTH, 0.0),
        (STRUCTURE, TRUTH, 20.0),
        (RIGID, {}, 0.0),
        (TOOL, TRUTH, 0.0),
        (THREE, TRUTH | {"link.spring.k1": 5e6, "tool.inertia.J": 100.0}, 0.0),
        (Structure((*STRUCTURE.terms, "arm.gravity"), gear_ratio=STRUCTURE.gear_ratio), TRUTH, 5.0),
    ],
    ids=["paper", "moving", "rigid", "tool", "three masses", "gravity"],
)
def test_the_response_is_that_of_the_joint(
    structure: Structure, values: dict[str, float], speed: float, tmp_path: Path
) -> None:
    fit = fit_of(structure, values)
    write_tree(tmp_path / "m.mat", model_tree(fit, speed, {"a": 0.001}))
    m = loadmat(tmp_path / "m.mat", squeeze_me=True)
    m |= {name: np.reshape(m[name], (len(m["A"]), 1)) if name == "B" else np.atleast_1d(m[name]) for name in "BD"}
    linear = linear_of(structure, fit, speed)
    np.testing.assert_allclose(answer(m, "ddphi_m"), linear.response(OMEGA), rtol=1e-9)
    np.testing.assert_allclose(answer(m, "dphi_m"), linear.speed_response(OMEGA), rtol=1e-9)
    np.testing.assert_allclose(answer(m, "phi_m") * 1j * OMEGA, linear.speed_response(OMEGA), rtol=1e-8)
    assert float(m["operating_point"]["dphi_m"]) == speed
    assert float(m["sampling_time"]["a"]) == 0.001


def test_the_arm_follows_through_the_spring(tmp_path: Path) -> None:
    write_tree(tmp_path / "m.mat", model_tree(fit_of(STRUCTURE, TRUTH), 0.0, {}))
    m = loadmat(tmp_path / "m.mat", squeeze_me=True)
    m["B"], m["D"] = m["B"][:, None], m["D"][:, None]
    s, (k, _, d, J) = 1j * OMEGA, list(TRUTH.values())[3:]
    assert STRUCTURE.gear_ratio is not None
    through = STRUCTURE.gear_ratio * (d * s + k) / (J * s**2 + d * s + k)
    np.testing.assert_allclose(answer(m, "phi_a") / answer(m, "phi_m"), through, rtol=1e-8)
    np.testing.assert_allclose(answer(m, "dphi_a") / answer(m, "dphi_m"), through, rtol=1e-8)


def test_parameters_are_structs_with_their_units(tmp_path: Path) -> None:
    write_tree(tmp_path / "m.mat", model_tree(fit_of(STRUCTURE, TRUTH), 0.0, {}))
    m = loadmat(tmp_path / "m.mat", simplify_cells=True)
    k1 = m["parameters"]["gear"]["spring"]["k1"]
    assert k1["value"] == pytest.approx(TRUTH["gear.spring.k1"])
    assert (k1["unit"], k1["std"], k1["std_robust"], k1["fixed"]) == ("Nm/rad", 0.1, 0.2, 0)
    assert m["state_names"].tolist() == ["twist", "phi_m", "dphi_m", "dphi_a"]
    assert m["state_units"].tolist() == ["rad", "rad", "rad/s", "rad/s"]
    assert m["fit_percent"]["a"] == 99.0


def test_a_sliding_axis_has_its_own_units() -> None:
    sliding = Structure(RIGID.terms, linear=True)
    tree = model_tree(fit_of(sliding, {}), 0.0, {})
    assert (tree["output_units"], tree["input_units"]) == (("m", "m/s", "m/s2"), ("N",))
    assert tree["operating_point"]["unit"] == "m/s"


def test_channels_are_named_for_they_are_not_in_the_matrices() -> None:
    delayed = Structure(RIGID.terms, ("torque.torque_delay",))
    tree = model_tree(fit_of(delayed, {}), 0.0, {})
    assert tree["channels"] == ("torque.torque_delay",)
    assert tree["meaning"].endswith("are not part of A to D")
