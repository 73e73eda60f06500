"""Companions in time, and joints beside them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from robotid.catalogue import assemble
from robotid.errors import ConfigError, InputError, NumericsError
from robotid.model.companion import Course, SmoothCourse, companion_of, with_companion
from robotid.model.derivatives import DerivativeColumns
from robotid.model.structure import Structure

AXIS = Structure(("motor.inertia", "motor.pose_inertia[q2]"))
RAMP = Course(np.array([[1.0, 2.0, 4.0], [0.1, 0.2, 0.4], [0.0, 0.0, 6.0]]), sampling_time=0.5, begin=10.0)


@dataclass(frozen=True)
class Log:
    name: str = "log"
    courses: dict[str, Course] = field(default_factory=dict)
    motor_course: Course = RAMP


def test_a_course_is_linear_between_its_samples_and_constant_beyond() -> None:
    found = RAMP.at(np.array([0.0, 10.0, 10.25, 10.5, 10.75, 11.0, 99.0]))
    np.testing.assert_allclose(found[0], [1.0, 1.0, 1.5, 2.0, 3.0, 4.0, 4.0], rtol=1e-15)
    np.testing.assert_allclose(found[2], [0.0, 0.0, 0.0, 0.0, 3.0, 6.0, 6.0], rtol=1e-15)


def test_an_instant_that_is_no_number_does_no_harm() -> None:
    assert np.isfinite(RAMP.at(np.array([np.nan, np.inf, -np.inf]))).all()


def test_a_course_of_one_sample_rests() -> None:
    np.testing.assert_array_equal(RAMP.resting.at(np.array([0.0, 50.0])), [[7 / 3] * 2, [0.0] * 2, [0.0] * 2])


def test_a_smooth_course_goes_as_its_rate_asks() -> None:
    """A cubic is met wherever it is asked for, and the last value stays."""
    t = np.array([2.0, 2.5, 3.0])
    course = SmoothCourse(np.stack([t**3 - t, 3.0 * t**2 - 1.0, 6.0 * t]), sampling_time=0.5, begin=2.0)
    at = np.linspace(2.0, 3.0, 11)
    np.testing.assert_allclose(course.at(at)[0], at**3 - at, rtol=1e-13)
    np.testing.assert_allclose(course.at(np.array([1.0, 4.0]))[0], [6.0, 24.0], rtol=1e-13)
    assert not np.allclose(Course(course.samples, 0.5, 2.0).at(at)[0], at**3 - at, rtol=1e-3)


@pytest.mark.parametrize("kind", [Course, SmoothCourse])
def test_the_value_alone_is_that_beside_its_derivatives(kind: type[Course]) -> None:
    course = kind(np.random.default_rng(0).normal(size=(3, 9)), sampling_time=0.5, begin=2.0)
    at = np.random.default_rng(1).uniform(0.0, 9.0, 50)
    np.testing.assert_array_equal(course.value(at), course.at(at)[0])


def test_names_carry_the_companion() -> None:
    assert companion_of("arm.pose_inertia[q2]") == ("arm.pose_inertia", "q2")
    assert companion_of("motor.coulomb") == ("motor.coulomb", "")
    assert with_companion("pose_inertia", "q2") == "pose_inertia[q2]"
    assert assemble(AXIS).names[1:] == tuple(f"motor.pose_inertia[q2].{s}" for s in "ABn")


def test_a_joint_without_companions_is_itself_beside_any_record() -> None:
    joint = assemble(Structure(("motor.inertia",)))
    assert joint.along(Log()) is joint
    assert not joint.reads_companions


def test_a_record_that_lacks_what_is_read_is_refused() -> None:
    with pytest.raises(InputError, match=r"pose_inertia\[q2\] reads q2, which was not recorded") as caught:
        assemble(AXIS).along(Log(courses={"q3": RAMP}))
    assert caught.value.where == "log"


@pytest.mark.parametrize(
    ("effect", "words"),
    [("motor.pose_inertia", "reads a companion"), ("motor.coulomb[q2]", "reads no companion")],
)
def test_an_effect_names_a_companion_if_and_only_if_it_reads_one(effect: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        assemble(Structure(("motor.inertia", effect)))


def test_the_joint_moves_with_the_inertia_of_the_pose() -> None:
    """J(w) a + dJ/dw dw v = u, with J = 4 + 3 sin(w)."""
    joint = assemble(AXIS).along(Log(courses={"q2": RAMP}))
    theta = joint.parameters().with_values([4.0, 3.0, 0.0, 1.0]).values
    t, v, u = np.array([10.0, 10.25, 11.0]), np.array([[5.0, -1.0, 2.0]]), np.array([7.0, 7.0, 7.0])
    w, dw = np.array([1.0, 1.5, 4.0]), np.array([0.1, 0.15, 0.4])
    found = joint.evaluate(v, u, np.sign(v), t, theta, columns=DerivativeColumns((0, 1, 2)))
    inertia = 4.0 + 3.0 * np.sin(w)
    np.testing.assert_allclose(found.f[0], (u - 3.0 * np.cos(w) * dw * v[0]) / inertia, rtol=1e-14)
    assert found.B is not None
    np.testing.assert_allclose(found.B[0, 0], -found.f[0] / inertia, rtol=1e-14)


def test_a_linear_response_is_that_at_the_mean_pose() -> None:
    joint = assemble(AXIS).along(Log(courses={"q2": RAMP}))
    resting = joint.at_mean_companions()
    w, dw, ddw = resting.companions["q2"].at(np.zeros(1))
    assert (w.item(), dw.item(), ddw.item()) == (pytest.approx(7 / 3), 0.0, 0.0)


def test_a_mass_that_some_pose_takes_away_is_refused() -> None:
    joint = assemble(AXIS).along(Log(courses={"q2": RAMP}))
    theta = joint.parameters().with_values([2.0, 3.0, 0.0, 1.0]).values
    t = np.array([10.0, 10.5, 11.0])
    one = np.ones((1, 2))
    joint.evaluate(one, one[0], one, t[:2], theta)
    with pytest.raises(NumericsError, match="a mass is not positive in every pose"):
        joint.evaluate(one, one[0], one, t[1:], theta)  # 2 + 3 sin(4) < 0


class Counted(Course):
    """A companion that counts how often it is worked out."""

    asked: list[str] = []

    def at(self, t: np.ndarray) -> np.ndarray:
        self.asked.append("at")
        return super().at(t)

    def value(self, t: np.ndarray) -> np.ndarray:
        self.asked.append("value")
        return super().value(t)


def test_effects_that_read_one_companion_work_it_out_once() -> None:
    joint = assemble(Structure(("motor.inertia", "motor.pose_inertia[q2]", "motor.pose_lever[q2]")))
    Counted.asked.clear()
    beside = joint.along(Log(courses={"q2": Counted(RAMP.samples, 0.5, 10.0)}))
    theta = joint.parameters().values
    beside.evaluate(np.ones((1, 5)), np.zeros(5), np.ones((1, 5)), np.arange(5.0), theta)
    assert Counted.asked == ["at"]


def test_a_recorded_angle_that_no_effect_reads_is_not_worked_out() -> None:
    structure = Structure(("motor.inertia", "motor.coulomb", "motor.gravity"), recorded_angle=True)
    theta, x = assemble(structure).parameters().values, np.ones((2, 5))
    for terms, asked in ((structure.terms, ["value"]), (structure.terms[:2], [])):
        joint = assemble(Structure(terms), angle=True)
        joint.companions = {"phi_m": Counted(RAMP.samples, 0.5, 10.0)}
        Counted.asked.clear()
        joint.evaluate(x, np.zeros(5), np.ones((1, 5)), np.arange(5.0), theta[: len(joint.names)])
        assert Counted.asked == asked
