"""Signals found among columns, and in SI."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.errors import ConfigError
from robotid.signals.columns import Column, convert, ending, find, short
from robotid.signals.readers.table import Table

ONES = np.ones(5)


def table(*names: str, **units: str) -> Table:
    return Table("a.csv", dict.fromkeys(names, ONES), units)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("rec.MotorAngle", "motor_angle"),
        ("q.signals.values", "q"),
        ("logsout.angle.data", "angle"),
        ("Motor Angle", "motor_angle"),
        ("phi_m", "phi_m"),
    ],
)
def test_short(name: str, expected: str) -> None:
    assert short(name) == expected


@pytest.mark.parametrize(
    ("name", "stem", "unit"),
    [
        ("MotorAngle_deg", "motor_angle", "deg"),
        ("act_vel_deg_per_s", "act_vel", "deg/s"),
        ("time_s", "time", "s"),
        ("effort_mNm", "effort", "mNm"),
        ("Drehzahl_1/min", "drehzahl", "rpm"),
        ("velocity_mdeg/s", "velocity", "mdeg/s"),
        ("flow_litre/s", "flow_litre_s", None),
        ("logsout.torque_Nm.data", "torque", "Nm"),
        ("u_volt", "u", "V"),
        ("phi_m", "phi_m", None),
        ("phi_a", "phi_a", None),
        ("t_min", "t_min", None),
        ("speed", "speed", None),
        ("deg", "deg", None),
        ("Grad", "grad", "deg"),
        ("Motorstrom_A", "motorstrom", "A"),
        ("Strom", "strom", "A"),
    ],
)
def test_ending(name: str, stem: str, unit: str | None) -> None:
    found = ending(name)
    assert (found[0], found[1].name if found[1] else None) == (stem, unit)


@pytest.mark.parametrize(
    ("signal", "name"),
    [("t", "time_ms"), ("tau_m", "Torque"), ("phi_m", "rec.q"), ("phi_m", "angle_deg"), ("dphi_m", "speed_rpm")],
)
def test_found_by_name(signal: str, name: str) -> None:
    assert find(table("other", name), signal) == Column(name)


def test_the_name_itself_comes_before_others() -> None:
    assert find(table("q", "phi_m", "pos"), "phi_m") == Column("phi_m")


def test_a_name_that_ends_in_a_unit_of_something_else_is_not_found() -> None:
    assert find(table("angle_Nm"), "phi_m") is None


def test_the_same_name_in_two_structs_is_ambiguous() -> None:
    with pytest.raises(
        ConfigError, match=r"rec\.ref and sim\.ref could both be ref; .*, or that there is none, ref: null"
    ):
        find(table("rec.ref", "sim.ref"), "ref")


def test_value_is_scale_times_recorded_plus_offset_in_the_unit() -> None:
    column = Column("phi", unit="deg", scale=2.0, offset=-1.0)
    np.testing.assert_allclose(convert(table("phi"), "phi_m", column).values, np.deg2rad(1.0), rtol=1e-15)


def test_the_configured_unit_comes_before_the_files_and_that_before_the_names() -> None:
    source = table("phi_deg", phi_deg="rev")
    assert convert(source, "phi_m", Column("phi_deg", unit="mrad")).values[0] == pytest.approx(1e-3)
    assert convert(source, "phi_m", Column("phi_deg")).values[0] == pytest.approx(2 * np.pi)
    named = convert(table("phi_deg"), "phi_m", Column("phi_deg"))
    assert named.values[0] == pytest.approx(np.pi / 180)
    assert named.remark == "phi_m is taken to be in deg, as the name of column phi_deg ends"


def test_si_needs_no_remark() -> None:
    assert convert(table("time_s"), "t", Column("time_s")).remark == ""
    assert convert(table("phi_m"), "phi_m", Column("phi_m")).remark == ""


@pytest.mark.parametrize("unit", ["V", "A", "%"])
def test_a_drives_unit_is_torque_by_its_scale(unit: str) -> None:
    signal = convert(table("u"), "tau_m", Column("u", unit=unit, scale=35.15))
    np.testing.assert_array_equal(signal.values, 35.15 * ONES)
    assert signal.remark == f"tau_m is 35.15 Nm per {unit} of column u"
    with pytest.raises(ConfigError) as error:
        convert(table("u"), "tau_m", Column("u", unit=unit))
    assert error.value.what == f"tau_m is in {unit} and needs a scale"
    constant = ", the torque constant" if unit == "A" else ""
    assert error.value.hint == f"write tau_m: {{name: u, scale: ...}} with the Nm per {unit}{constant}"


def test_a_sliding_axis_has_metres_and_newtons() -> None:
    assert convert(table("x"), "phi_m", Column("x", unit="mm"), linear=True).values[0] == 1e-3
    with pytest.raises(ConfigError, match="phi_m cannot be in deg; give its unit, such as m, or another column"):
        convert(table("x"), "phi_m", Column("x", unit="deg"), linear=True)


def test_a_joint_that_turns_has_radians() -> None:
    with pytest.raises(ConfigError, match="phi_m cannot be in mm; give its unit, such as rad, or another column"):
        convert(table("x"), "phi_m", Column("x", unit="mm"))
