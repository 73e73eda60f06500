import numpy as np
import pytest

from robotid.errors import ConfigError
from robotid.model.array import Array
from robotid.signals.differentiate import Kinematics
from robotid.signals.limits import Limits, check_limits, motion
from robotid.signals.record import Quantity
from robotid.signals.reference import Reference
from robotid.signals.waves import square, triangle


def reference(ref: Array, kind: Quantity = "speed", sampling_time: float = 0.5) -> Reference:
    return Reference("set1", sampling_time, ref, kind)


PAPER = reference(triangle(40.0, 10_000, 12_500), sampling_time=5e-4)


def weight(followed: Kinematics) -> Array:
    """Torque of an inertia of 0.05 kg m2 with Coulomb friction of 0.5 Nm."""
    return 0.05 * followed.acceleration + 0.5 * np.sign(followed.speed)


def test_motion_of_a_speed_reference_by_hand() -> None:
    followed = motion(reference(np.array([1.0, 2.0, 2.0, -2.0])))
    assert followed.position.tolist() == [0.0, 0.75, 1.75, 1.75]
    assert followed.speed.tolist() == [1.0, 2.0, 2.0, -2.0]
    assert followed.acceleration.tolist() == [2.0, 2.0, 0.0, -8.0]


def test_motion_of_a_position_reference_by_hand() -> None:
    followed = motion(reference(np.array([3.0, 4.0, 6.0, 6.0]), "position"))
    assert followed.position.tolist() == [3.0, 4.0, 6.0, 6.0]
    assert followed.speed.tolist() == [0.0, 2.0, 4.0, 0.0]
    assert followed.acceleration.tolist() == [0.0, 4.0, 4.0, -8.0]


def test_what_the_papers_set_1_reaches_is_allowed() -> None:
    """40 rad/s, 4 * 40 / 5 rad/s2, half a period's area 40 * 2.5 / 2 rad, and 0.05 * 32 + 0.5 Nm."""
    check_limits(PAPER, Limits(speed=40.0, acceleration=32.0, position=50.0, torque=2.1), weight)


def test_without_limits_everything_is_allowed() -> None:
    check_limits(reference(np.array([0.0, 1e9])), Limits())


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        (
            Limits(speed=39.0),
            "set1: the speed reaches 40 rad/s at 1.25 s, the limit is 39 rad/s; "
            "lower amplitude or peak, or raise limits.speed",
        ),
        (
            Limits(acceleration=31.0),
            "set1: the acceleration reaches 32 rad/s2 at 0.0005 s, the limit is 31 rad/s2; "
            "lower amplitude or peak, give a square wave a rise time, or raise limits.acceleration",
        ),
        (
            Limits(position=45.0),
            "set1: the position reaches 50 rad at 2.5 s, the limit is 45 rad; "
            "lower amplitude or peak, shorten the period, or raise limits.position",
        ),
        (
            Limits(torque=2.0),
            "set1: the torque reaches 2.1 Nm at 0.0005 s, the limit is 2 Nm; "
            "lower amplitude or peak, give a square wave a rise time, or raise limits.torque",
        ),
    ],
)
def test_messages(limits: Limits, message: str) -> None:
    with pytest.raises(ConfigError) as error:
        check_limits(PAPER, limits, weight)
    assert str(error.value) == message


def test_a_sliding_axis_speaks_of_metres() -> None:
    with pytest.raises(ConfigError, match=r"the speed reaches 40 m/s at 1\.25 s, the limit is 30 m/s"):
        check_limits(PAPER, Limits(speed=30.0), sliding=True)


def test_a_square_wave_keeps_a_limit_of_acceleration_with_a_rise_time_only() -> None:
    """Between -8 and 8 rad/s in 0.1 s: 160 rad/s2. In one sample of 0.5 ms: 32000."""
    limits = Limits(acceleration=160.0)
    check_limits(reference(square(8.0, 10_000, 10_000, rise=200), sampling_time=5e-4), limits)
    with pytest.raises(ConfigError, match=r"reaches 3\.2e\+04 rad/s2 at 2\.5 s"):
        check_limits(reference(square(8.0, 10_000, 10_000), sampling_time=5e-4), limits)
