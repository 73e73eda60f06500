"""What is told of a record, checked on records that are known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from robotid.artifacts import codec
from robotid.errors import InputError, NumericsError
from robotid.signals.quality import Recordings, inspect, jump, quantum, saturation
from robotid.signals.record import Record

H = 1e-3
T = np.arange(4000) * H
SLOW = 10 * np.sin(2 * np.pi * T)


def record() -> Record:
    """Four swings of a motor with a torque of 1 Hz."""
    angle = -10 / (2 * np.pi) * np.cos(2 * np.pi * T)
    return Record("a", "estimate", "both", H, tau_m=2 * np.cos(2 * np.pi * T), phi_m=angle, dphi_m=SLOW)


def test_a_known_record() -> None:
    report = inspect(record(), "a.csv")
    assert (report.samples, report.sampling_time, report.duration) == (4000, H, 4.0)
    assert report.reversals == 7
    assert report.torque_rms == pytest.approx(np.sqrt(2), rel=1e-3)
    assert report.torque_range == pytest.approx((-2, 2))
    assert report.speed_range == pytest.approx((-10, 10))
    assert report.torque_bandwidth == pytest.approx(1.0, abs=0.3)
    assert report.saturation == 0.0
    assert report.still < 0.01
    assert report.remarks == ()


def test_it_is_kept_in_an_artifact(tmp_path: Path) -> None:
    whole = Recordings((record(),), (inspect(record(), "a.csv", remarks=("said",)),))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        codec.write(file.create_group("x"), whole)
        back = codec.read(file["x"], Recordings)
    assert back.reports == whole.reports
    np.testing.assert_array_equal(back["a"].phi_m, record().phi_m)


@pytest.mark.parametrize("step", [2 * np.pi / 65536, 5e-8, 0.01])
def test_quantum(step: float) -> None:
    angle = 400 * step * SLOW
    assert quantum(step * np.rint(angle / step)) == pytest.approx(step, rel=1e-6)


def test_quantum_of_an_angle_with_few_digits() -> None:
    step = 360 / 65536
    assert quantum(np.round(step * np.rint(50 * SLOW / step), 4)) == pytest.approx(step, rel=1e-3)


def test_no_quantum_where_none_is() -> None:
    assert quantum(SLOW + 1e-3 * np.random.default_rng(1).normal(size=len(SLOW))) == 0.0
    assert quantum(np.ones(10)) == 0.0


def test_saturation_is_told() -> None:
    clipped = np.clip(SLOW, -8, 8)
    assert saturation(clipped) == pytest.approx(0.41, abs=0.01)
    report = inspect(replace(record(), tau_m=clipped), "a.csv")
    assert report.remarks == ("the torque sits at its largest or smallest value in 41 % of the samples: saturated?",)


def test_a_jump_is_told() -> None:
    angle = record().phi_m.copy()
    angle[2500:] += 3.0
    assert jump(record().phi_m) is None
    assert jump(angle) == 2500
    remarks = inspect(replace(record(), phi_m=angle), "a.csv").remarks
    assert remarks == ("phi_m jumps by 3 within a sample at 2.5 s, unlike its neighbours",)


def test_a_time_in_milliseconds_is_suspected() -> None:
    remarks = inspect(replace(record(), sampling_time=1.0), "a.csv").remarks
    assert remarks == ("a sampling time of 1 s is unusual: is the unit of time right?",)


@pytest.mark.parametrize(
    ("changed", "line"),
    [
        ({"tau_m": np.full(4000, 0.2)}, "the torque never changes"),
        ({"phi_m": np.full(4000, 0.2)}, "the motor never moves"),
        ({"phi_m": 1e-4 * (np.arange(4000) // 10 % 3)}, "the motor moves by 2 of its encoder's steps and no more"),
    ],
)
def test_without_excitation(changed: dict[str, np.ndarray], line: str) -> None:
    with pytest.raises(NumericsError) as error:
        inspect(replace(record(), **changed), "a.csv")
    assert str(error.value) == f"a.csv: {line}; record a motion that excites the joint, or check the columns"


def test_too_short() -> None:
    with pytest.raises(InputError, match="a record of 49 samples is too short, the least is 50"):
        inspect(record().piece(0, 49), "a.csv")
