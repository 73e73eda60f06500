"""Further signals of a log: read in their unit, repaired and cut as the others, differentiated without delay."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from robotid.artifacts import codec
from robotid.errors import ConfigError
from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.signals.columns import Column
from robotid.signals.companion import Companion, acceleration_band, derivatives, together
from robotid.signals.measured import CompanionColumn, Selection, measured_records
from robotid.signals.plausibility import Axis, check_records
from robotid.signals.quality import Recordings, inspect
from robotid.signals.readers.table import Table
from robotid.signals.record import Record

H, N = 2e-3, 3000
T = np.arange(N) * H
ANGLE = 2.0 * np.sin(2 * np.pi * 0.8 * T) + 0.3 * np.sin(2 * np.pi * 3.0 * T)
TORQUE = np.gradient(np.gradient(ANGLE, H), H) * 0.05 + np.gradient(ANGLE, H) * 0.02
OTHER = 0.7 * np.sin(2 * np.pi * 0.5 * T + 0.4)
KINDS = {"q2": "angle", "oil": "temperature", "cell": "torque", "bus": "voltage", "pulses": "disturbance"}


def read(columns: dict[str, Array], kind: str, unit: str | None = None, t: Array = T, **given: Any) -> list[Record]:
    table = Table("a.csv", {"t": t, "tau_m": TORQUE, "phi_m": ANGLE, **columns})
    column = CompanionColumn(CompanionKind(kind), Column("further", unit=unit, **given))
    return [record for record, _ in measured_records(Selection("a", companions={"w": column}), table)]


@pytest.mark.parametrize(
    ("kind", "unit", "recorded", "kept"),
    [
        ("angle", "deg", 180.0, np.pi),
        ("temperature", "K", 300.0, 26.85),
        ("temperature", "°F", 212.0, 100.0),
        ("temperature", None, 31.0, 31.0),
        ("torque", "kNm", 0.2, 200.0),
        ("voltage", "mV", 48e3, 48.0),
        ("inertia", "kg m^2", 2.0, 2.0),
        ("drive", "mNm", 2e3, 2.0),
        ("disturbance", "Nm", 2.0, 2.0),
    ],
)
def test_every_kind_is_kept_in_its_unit(kind: str, unit: str | None, recorded: float, kept: float) -> None:
    (found,) = read({"further": np.linspace(0.0, recorded, N)}, kind, unit)
    first = {"K": -273.15, "°F": -160 / 9}.get(unit or "", 0.0)
    np.testing.assert_allclose(found.companions["w"].values[[0, -1]], [first, kept], rtol=1e-12)


@pytest.mark.parametrize(
    ("kind", "unit"), [("angle", "Nm"), ("temperature", "V"), ("torque", "V"), ("voltage", "degC")]
)
def test_another_quantity_is_refused(kind: str, unit: str) -> None:
    with pytest.raises(ConfigError, match=r"w cannot be in|w is in V and needs a scale"):
        read({"further": OTHER}, kind, unit)


def test_an_angle_that_wraps_around_is_unwrapped() -> None:
    turning = 40.0 * T
    (found,) = read({"further": np.mod(turning, 2 * np.pi)}, "angle")
    np.testing.assert_allclose(found.companions["w"].values, turning, atol=1e-9)


def test_a_companion_is_resampled_with_the_others() -> None:
    rng = np.random.default_rng(1)
    t = T + 0.2 * H * rng.uniform(-1.0, 1.0, N)
    jittery = {"tau_m": np.interp(t, T, TORQUE), "phi_m": np.interp(t, T, ANGLE)}
    (found,) = read({**jittery, "further": 3.0 + 0.5 * jittery["phi_m"]}, "angle", t=t)
    assert len(found) < N
    np.testing.assert_allclose(found.companions["w"].values, 3.0 + 0.5 * found.phi_m, atol=1e-4)


def test_a_gap_cuts_a_companion_too() -> None:
    kept = np.r_[0:1200, 1600:N]
    table = Table("a.csv", {"t": T[kept], "tau_m": TORQUE[kept], "phi_m": ANGLE[kept], "further": OTHER[kept]})
    column = CompanionColumn(CompanionKind.ANGLE, Column("further"))
    pieces = [record for record, _ in measured_records(Selection("a", companions={"w": column}), table)]
    assert [len(piece.companions["w"].values) for piece in pieces] == [1200, N - 1600]
    np.testing.assert_array_equal(pieces[1].companions["w"].values, OTHER[1600:])


def test_speed_and_acceleration_are_not_late() -> None:
    noisy = OTHER + 1e-4 * np.random.default_rng(2).standard_normal(N)
    speed, acceleration = derivatives(noisy, H)
    phase, omega = 2 * np.pi * 0.5 * T + 0.4, np.pi
    inner = slice(200, -200)
    assert np.abs(speed - 0.7 * omega * np.cos(phase))[inner].max() < 0.01 * omega
    assert np.abs(acceleration + 0.7 * omega**2 * np.sin(phase))[inner].max() < 0.05 * omega**2
    lag = np.argmax(np.correlate(speed[inner], np.cos(phase)[inner], "full")) - (N - 401)
    assert lag == 0


def accompanied() -> Record:
    plain = Record.from_arrays(TORQUE, ANGLE, H, name="a")
    found = {name: Companion.of(CompanionKind(kind), OTHER + 20.0, H) for name, kind in KINDS.items()}
    return replace(plain, companions=found)


def test_pieces_and_their_whole() -> None:
    whole = accompanied()
    pieces = [whole.piece(0, 1000), whole.piece(1000, N)]
    assert pieces[1].courses["q2"].begin == pytest.approx(1000 * H)
    for name, one in whole.companions.items():
        again = together([piece.companions[name] for piece in pieces])
        np.testing.assert_array_equal(again.values, one.values)
        assert (again.speed is None) == (one.speed is None) == (name != "q2")
    np.testing.assert_array_equal(whole.disturbance, OTHER + 20.0)


def test_companions_survive_the_file(tmp_path: Path) -> None:
    whole = accompanied()
    with h5py.File(tmp_path / "a.h5", "w") as file:
        codec.write(file, whole)
        again = codec.read(file, Record)
        assert file["companions/oil/values"].attrs["unit"] == "degC"
    for name, one in whole.companions.items():
        assert again.companions[name].kind is one.kind
        np.testing.assert_array_equal(again.companions[name].values, one.values)
    np.testing.assert_array_equal(again.companions["q2"].acceleration, whole.companions["q2"].acceleration)


def findings(**companions: Companion) -> list[tuple[str, str]]:
    record = replace(Record.from_arrays(TORQUE, ANGLE, H, name="a"), companions=companions)
    found = check_records(Recordings((record,), (inspect(record, "a"),)), Axis())
    return [(one.name, one.severity) for one in found.findings if one.name.startswith("companion")]


@pytest.mark.parametrize(
    ("check", "kind", "values"),
    [
        ("companion_constant", "angle", np.full(N, 0.3)),
        ("companion_size", "angle", 57.3 * OTHER),
        ("companion_size", "temperature", 270.0 + OTHER),
        ("companion_copy", "angle", -0.01 * ANGLE + 3.0),
    ],
)
def test_a_mistake_in_a_companion_is_found(check: str, kind: str, values: Array) -> None:
    assert findings(w=Companion.of(CompanionKind(kind), values, H)) == [(check, "warning")]


def test_companions_that_make_sense_have_no_finding() -> None:
    angle, oil = Companion.of(CompanionKind.ANGLE, OTHER, H), Companion.of(CompanionKind.TEMPERATURE, 30.0 + T, H)
    assert findings(q2=angle, oil=oil) == []


def test_two_companions_that_are_one_are_found() -> None:
    one, same = Companion.of(CompanionKind.ANGLE, OTHER, H), Companion.of(CompanionKind.ANGLE, 1.0 - 2.0 * OTHER, H)
    assert findings(q2=one, q3=same) == [("companion_copy", "warning")]


@pytest.mark.parametrize("quantum", [0.0, 1e-6])
def test_fast_motion_on_a_slow_swing_is_differentiated_too(quantum: float) -> None:
    """A thousandth of the energy of the speed is most of the acceleration."""
    omega, fast = 2 * np.pi * 0.5, 2 * np.pi * 25.0
    angle = np.sin(omega * T) + 4e-4 * np.sin(fast * T)
    recorded = np.round(angle / quantum) * quantum if quantum else angle
    _, acceleration = derivatives(recorded, H)
    inner = slice(N // 20, -N // 20)
    expected = -(omega**2) * np.sin(omega * T) - 4e-4 * fast**2 * np.sin(fast * T)
    error = np.std((acceleration - expected)[inner])
    assert error < 0.03 * np.std(expected)
    assert acceleration_band(recorded, H) == pytest.approx(25.0, abs=1.0)


def test_the_noise_of_an_angle_is_no_motion() -> None:
    noisy = OTHER + 1e-3 * np.random.default_rng(3).standard_normal(N)
    assert acceleration_band(noisy, H) < 3.0
    assert acceleration_band(noisy[:200], H) == 0.0
