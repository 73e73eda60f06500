from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from body.test_regressor import planar_chain, planar_links, random_chain
from support import planar_arm

from robotid.body.chain import PER_LINK
from robotid.body.consistent import body, is_consistent
from robotid.body.equations import Motion, Structure
from robotid.body.identification import Knowledge, identify, structural_base
from robotid.body.regressor import torques
from robotid.errors import NumericsError

STRUCTURE = Structure(planar_chain(), ("viscous", "coulomb"))


def motion(seed: int, noise: float = 0.0, size: float = 1.0, fitted: bool = True) -> Motion:
    q, dq, ddq = planar_arm.swing(seed, np.linspace(0, 20, 600), size)
    error = noise * np.random.default_rng(100 + seed).normal(size=q.shape)
    torque = planar_arm.torque(q, dq, ddq) + error
    return Motion(f"set{seed}", q, dq, ddq, np.sign(dq), torque, fitted)


def test_the_plane_has_the_base_parameters_of_the_textbook() -> None:
    """Khalil & Dombre 2002, section 9.4: X1, Y1, ZZR1, X2, Y2, ZZ2 of two links in a vertical plane, and the drives."""
    base = structural_base(STRUCTURE)
    names = [name.split(" ")[0] for name in base.names(STRUCTURE.symbols)]
    of_links = [name for name in names if name.split(".")[1] in PER_LINK]
    rotors = [name for name in names if name.endswith(".J")]
    assert len(of_links) + len(rotors) == 7  # ZZR1 and the first rotor are one
    assert {"a1.mx", "a1.my", "a2.mx", "a2.my"} - set(of_links) <= {"a1.mx"}  # or m2, for X1 = m1 x1 + L m2
    assert len(names) == 7 + 4


def test_drives_and_base_parameters_are_found_and_carry_over() -> None:
    found = identify(STRUCTURE, [motion(1, 0.05), motion(2, 0.05, fitted=False)], Knowledge()).result
    for k, axis in enumerate(("a1", "a2")):
        assert found[f"{axis}.Fv"].value == pytest.approx(planar_arm.VISCOUS[k], rel=0.02)
        assert found[f"{axis}.Fc"].value == pytest.approx(planar_arm.DRY[k], rel=0.02)
        assert abs(found[f"{axis}.Fv"].value - planar_arm.VISCOUS[k]) < 4 * found[f"{axis}.Fv"].std
    held_out = found.errors[1]
    assert not held_out.fitted
    assert max(*held_out.base, *held_out.consistent) < 1.0
    for name in ("a2.mx", "a2.J"):
        estimate = next(b for b in found.base if b.name.startswith(name))
        truth = planar_arm.LOWER.mass * planar_arm.LOWER.centre if name == "a2.mx" else planar_arm.ROTORS[1]
        assert abs(estimate.value - truth) < 4 * estimate.std


def test_every_link_is_a_possible_body_whatever_the_noise() -> None:
    found = identify(STRUCTURE, [motion(1, 20.0, size=0.1)], Knowledge())
    for joint in found.chain.joints:
        assert joint.inertia is not None
        assert is_consistent(joint.inertia)


def test_poor_motions_carry_over_better_with_possible_bodies() -> None:
    """A small motion of five axes amid noise: the base parameters fit it, and mean nothing elsewhere."""
    rng, axes, t = np.random.default_rng(5), 5, np.linspace(0, 10, 400)
    structure = Structure(random_chain(1, count=axes), ("viscous",))
    links = np.concatenate([body(4.0 / (1 + k), c, 0.02 * np.eye(3)) for k, c in enumerate(rng.normal(size=(axes, 3)))])

    def swinging(name: str, size: float, noise: float, fitted: bool) -> Motion:
        w, phase = 2 * np.pi * rng.uniform(0.1, 0.5, (axes, 1)), rng.uniform(0, 6, (axes, 1))
        q, dq = size * np.sin(w * t + phase), size * w * np.cos(w * t + phase)
        ddq = -(w**2) * q
        torque = torques(structure.chain, links, q, dq, ddq) + 2.0 * dq
        error = noise * np.std(torque, axis=1, keepdims=True) * rng.normal(size=q.shape)
        return Motion(name, q, dq, ddq, np.sign(dq), torque + error, fitted)

    motions = [swinging("small", 0.3, 0.1, True), swinging("large", 0.6, 0.0, False)]
    small, large = identify(structure, motions, Knowledge()).result.errors
    assert sum(small.base) <= sum(small.consistent)
    assert sum(large.consistent) < 0.5 * sum(large.base)


def test_fixed_masses_are_kept() -> None:
    links = planar_links().reshape(2, 10)
    joints = tuple(
        replace(joint, inertia=own, fixed=True) for joint, own in zip(planar_chain().joints, links, strict=True)
    )
    structure = replace(STRUCTURE, chain=replace(planar_chain(), joints=joints))
    found = identify(structure, [motion(1, 0.05)], Knowledge())
    assert np.array_equal(found.links, planar_links())
    assert found.result["a1.J"].value == pytest.approx(planar_arm.ROTORS[0], rel=0.05)
    assert found.result["a1.m"].fixed


def test_known_masses_are_where_the_estimate_starts() -> None:
    links = planar_links().reshape(2, 10)
    joints = tuple(replace(joint, inertia=own) for joint, own in zip(planar_chain().joints, links, strict=True))
    structure = replace(STRUCTURE, chain=replace(planar_chain(), joints=joints))
    masses = [
        identify(structure, [motion(1, 0.05)], Knowledge(given_factor=factor)).result["a1.m"] for factor in (1.05, 2.0)
    ]
    assert masses[0].start == planar_arm.UPPER.mass
    assert masses[0].value == pytest.approx(planar_arm.UPPER.mass, rel=0.05)
    assert masses[0].std < masses[1].std
    assert masses[0].seen < masses[1].seen


def test_what_is_not_seen_is_stated() -> None:
    q, dq, ddq = planar_arm.swing(1, np.linspace(0, 20, 600))
    q, dq, ddq = (np.array([1e-3, 1.0])[:, None] * one for one in (q, dq, ddq))
    one = Motion("set", q, dq, ddq, np.sign(dq), planar_arm.torque(q, dq, ddq))
    found = identify(Structure(planar_chain()), [one], Knowledge()).result  # the weight of the first link is an offset
    unseen = [b.name for b in found.base if not b.seen]
    assert unseen
    assert any(unseen[0] in remark for remark in found.remarks)


@pytest.mark.parametrize("wrong", [1.0, 1.5, 5.0])
def test_given_values_that_the_motions_contradict_are_stated(wrong: float) -> None:
    given = {"a1": planar_arm.ROTORS[0], "a2": wrong * planar_arm.ROTORS[1]}
    found = identify(STRUCTURE, [motion(1, 0.05)], Knowledge(rotors=given)).result
    stated = [remark for remark in found.remarks if "what is given" in remark]
    assert len(stated) == (wrong > 2.0)
    assert all("they put a2.J at 0.2 of it" in remark and "a1.J" not in remark for remark in stated)


def test_an_axis_that_stands_is_refused() -> None:
    one = motion(1)
    with pytest.raises(NumericsError, match="a2 never moves"):
        identify(STRUCTURE, [replace(one, q=one.q * [[1.0], [0.0]])], Knowledge())


def test_no_fitted_record_is_refused() -> None:
    with pytest.raises(NumericsError, match="no record"):
        identify(STRUCTURE, [motion(1, fitted=False)], Knowledge())


def test_few_samples_are_refused() -> None:
    one = motion(1)
    short = Motion("s", *(getattr(one, f)[:, :10] for f in ("q", "dq", "ddq", "direction", "torque")))
    with pytest.raises(NumericsError, match="too few"):
        identify(STRUCTURE, [short], Knowledge())
