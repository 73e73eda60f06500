"""A log is read from a file, a frame or arrays, alike; what is wrong with it is one sentence in terms of `read`."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.logs import motor_log
from support.paths import SHARED

import robotid as rid
from robotid.interface.hints import in_python

LOG = motor_log()
RADIANS = {"time": LOG["time"], "torque": LOG["torque"], "angle": np.deg2rad(LOG["angle_deg"])}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "my log.csv"
    columns = np.column_stack([LOG["time"], LOG["torque"], LOG["angle_deg"]])
    np.savetxt(path, columns, delimiter=",", header="time [s],torque [Nm],angle [deg]", comments="", fmt="%.12g")
    return path


def frame() -> Any:
    pandas = pytest.importorskip("pandas")
    return pandas.DataFrame(LOG)


def dated() -> Any:
    pandas = pytest.importorskip("pandas")
    start = pandas.Timestamp("2026-01-01")
    return pandas.DataFrame(LOG | {"time": start + pandas.to_timedelta(LOG["time"], unit="s")})


@pytest.mark.parametrize(
    "source", [lambda: LOG, lambda: RADIANS, frame, dated], ids=["degrees", "SI", "frame", "dates"]
)
def test_sources_alike(source: Callable[[], Any], file: Path) -> None:
    record, other = rid.read(file)[0], rid.read(source())[0]
    assert record.sampling_time == other.sampling_time == 0.002
    np.testing.assert_allclose(other.phi_m, record.phi_m, atol=1e-9)
    np.testing.assert_allclose(other.tau_m, record.tau_m, atol=1e-9)


def test_a_file_names_its_record_and_what_was_found_is_remarked(file: Path) -> None:
    data = rid.read(file)
    assert data.names == ("my_log",)
    assert "tau_m is column torque in Nm, found by its name" in data.reports[0].remarks


def test_units_in_the_call() -> None:
    plain = {"t": LOG["time"], "u": LOG["torque"] / 2.5, "enc": LOG["angle_deg"]}
    written = rid.read(plain, torque=rid.Column("u", unit="V", scale=2.5), angle="enc [deg]")[0]
    mapped = rid.read(plain, torque={"name": "u", "scale": 2.5}, angle={"name": "enc", "unit": "deg"})[0]
    for record in (written, mapped):
        np.testing.assert_allclose(record.tau_m, LOG["torque"])
        np.testing.assert_allclose(record.phi_m, RADIANS["angle"])


def test_a_signal_that_is_there_and_not_wanted() -> None:
    data = rid.read(RADIANS | {"speed": np.zeros(2000)}, speed=None)
    assert "dphi_m is derived from phi_m by central differences" in data.reports[0].remarks


def test_several_logs_are_one_dataset(file: Path) -> None:
    data = rid.read([file, LOG, LOG], role="validate")
    assert data.names == ("my_log", "record2", "record3")
    assert {record.role for record in data} == {"validate"}


def test_part_of_a_log_without_a_clock() -> None:
    signals = {name: RADIANS[name] for name in ("torque", "angle")}
    record = rid.read(signals, sampling_time=0.002, start=1.0, stop=2.0)[0]
    assert (len(record), record.t[0]) == (501, 0.0)
    np.testing.assert_array_equal(record.tau_m, LOG["torque"][500:1001])


def test_a_repair_that_is_asked_for() -> None:
    torque = LOG["torque"].copy()
    torque[100:140] = np.nan
    with pytest.raises(rid.RobotidError, match=r'give repair=\{"nan": "interpolate"\}'):
        rid.read(LOG | {"torque": torque})
    data = rid.read(LOG | {"torque": torque}, repair={"nan": "interpolate"})
    assert data.reports[0].not_finite == 40
    assert np.isfinite(data[0].tau_m).all()


def short(name: str) -> dict[str, Any]:
    return LOG | {name: LOG[name][:-1]}


def text(words: str) -> dict[str, Any]:
    return LOG | {"state": np.array([words] * 2000)}


NO_TORQUE = {"time": LOG["time"], "angle": LOG["time"]}
NO_CLOCK = {name: LOG[name] for name in ("torque", "angle_deg")}
VOLTS = {"time": LOG["time"], "u_volt": LOG["torque"], "angle": LOG["time"]}
SPEEDS = {"speed": LOG["time"], "vel": LOG["time"]}
BAD: dict[str, tuple[Callable[[], Any], str]] = {
    "wrong column": (lambda: rid.read(LOG, torque="torqe"), 'no column "torqe"; did you mean torque?'),
    "no torque": (lambda: rid.read(NO_TORQUE), "name it by torque=...; it holds time, angle"),
    "two torques": (
        lambda: rid.read(LOG | {"tau": LOG["torque"]}),
        "could both be tau_m; name it by torque=",
    ),
    "two speeds": (lambda: rid.read(LOG | SPEEDS), "say which by speed=..., or that there is none by speed=None"),
    "lengths": (lambda: rid.read(short("torque")), "columns differ in length: "),
    "unknown unit": (lambda: rid.read(LOG, torque="torque [Nmx]"), 'there is no unit "Nmx"; did you mean Nm?'),
    "volts": (
        lambda: rid.read(VOLTS, torque="u_volt"),
        'write torque=rid.Column("u_volt", scale=...) with the Nm per V',
    ),
    "text": (lambda: rid.read(text("ok"), torque="state"), 'column "state" holds text, such as "ok"'),
    "no clock": (lambda: rid.read(NO_CLOCK), "name the time column by time=..., or give sampling_time"),
    "no file": (lambda: rid.read("nowhere.csv"), "nowhere.csv: there is no such file; check the path"),
    "no format": (lambda: rid.read(__file__), 'no reader for the format ".py"'),
    "no source": (lambda: rid.read(3), "of type int"),
    "nothing": (lambda: rid.read({}), "there is no column of numbers"),
    "unknown setting": (lambda: rid.read(LOG, torqe="torque"), 'read takes no "torqe"; did you mean torque?'),
    "unknown role": (lambda: rid.read(LOG, role="validation"), "did you mean validate?"),
    "unknown repair": (lambda: rid.read(LOG, repair={"gap": "interpolate"}), 'no flaw "gap"; did you mean gaps?'),
    "repaired how": (lambda: rid.read(LOG, repair={"nan": "drop"}), "'drop' is unknown; one of refuse, interpolate"),
    "no name of a column": (lambda: rid.read(LOG, torque={"unit": "Nm"}), "a column needs a name"),
    "a column's key": (lambda: rid.read(LOG, torque={"name": "torque", "units": "Nm"}), "did you mean unit?"),
    "a column's kind": (lambda: rid.read(LOG, torque=3), "3 names no column"),
    "a name": (lambda: rid.read(LOG, name="my log"), '"my log" is no name of a record'),
    "one name for two": (lambda: rid.read([LOG, LOG], name="log"), "several logs cannot have one name"),
    "still": (lambda: rid.read(LOG | {"angle_deg": np.zeros(2000)}), "the motor never moves"),
    "constant": (lambda: rid.read(LOG | {"torque": np.ones(2000)}), "the torque never changes"),
    "too short": (lambda: rid.read({k: v[:30] for k, v in LOG.items()}), "a record of 30 samples is too short"),
    "backward": (lambda: rid.read(LOG | {"time": LOG["time"][::-1]}), "time runs backward"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_use_is_one_clear_sentence(case: str) -> None:
    call, words = BAD[case]
    with pytest.raises(rid.RobotidError) as caught:
        call()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "columns:" not in str(caught.value)


def test_hints_of_the_configuration_are_those_of_python() -> None:
    assert in_python("check unit and scale of both, or write dphi_m: null to derive it") == (
        "check unit and scale of both, or write speed=None to derive it"
    )
    assert in_python("write t: null under columns and give sampling_time instead") == (
        "give time=None and give sampling_time instead"
    )
    assert in_python("cut the record there by start or stop, or set repair: {gaps: interpolate}") == (
        'cut the record there by start or stop, or give repair={"gaps": "interpolate"}'
    )
    assert in_python("record longer") == "record longer"


def test_arrays_in_si() -> None:
    record = rid.Record.from_arrays(LOG["torque"], RADIANS["angle"], 0.002, name="log")
    np.testing.assert_array_equal(record.dphi_m, rid.read(RADIANS)[0].dphi_m)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"torque": np.where(LOG["time"] == 0.2, np.nan, LOG["torque"])}, "torque is not a number in 1 of 2000"),
        ({"torque": LOG["torque"][:-1]}, "the arrays differ in length: torque 1999, angle 2000"),
        (
            {"torque": np.where(LOG["time"] == 0.2, np.nan, LOG["torque"])},
            "torque is not a number in 1 of 2000 samples",
        ),
        ({"torque": LOG["torque"][:, None]}, "torque is an array of shape (2000, 1)"),
        ({"torque": ["a"] * 2000}, "torque is no array of numbers"),
        ({"sampling_time": 0.0}, "a sampling time of 0 s is not positive"),
        ({"torque": [], "angle": []}, "a record of 0 samples is too short"),
    ],
)
def test_bad_arrays(changed: dict[str, Any], words: str) -> None:
    good: dict[str, Any] = {"torque": LOG["torque"], "angle": RADIANS["angle"], "sampling_time": 0.002}
    with pytest.raises(rid.RobotidError, match=re.escape(words)):
        rid.Record.from_arrays(**(good | changed))


def test_a_real_log_of_a_sliding_axis() -> None:
    file = SHARED / "emps" / "DATA_EMPS.mat"
    if not file.is_file():
        pytest.skip("the measured records are not here")
    force = rid.Column("vir", scale=35.15065188248547)
    data = rid.read(file, name="train", torque=force, angle="qm", speed=None, linear=True)
    model = rid.Model(motor=["inertia", "viscous", "coulomb", "constant_torque"], linear=True)
    fit = rid.fit(model, data, options=rid.Options(output="position", horizon=5))
    assert fit["motor.inertia.J"].value == pytest.approx(95.1, rel=0.02)  # Janot et al. 2019
    assert "kg " in str(fit)


def test_companions_are_further_columns() -> None:
    log = motor_log() | {"axis2": np.linspace(0.0, 90.0, 2000)}
    data = rid.read(log, signals={"q2": {"name": "axis2", "unit": "deg", "kind": "angle"}})
    found = data[0].companions["q2"]
    assert (str(found.kind), found.unit) == ("angle", "rad")
    np.testing.assert_allclose(found.values[[0, -1]], [0.0, np.pi / 2], rtol=1e-12)


@pytest.mark.parametrize(
    ("signals", "words"),
    [
        ({"q2": {"name": "axis2"}}, "needs a column and a kind"),
        ({"q2": {"name": "axis2", "kind": "angel"}}, "'angel' is unknown"),
        ({"phi_m": {"name": "axis2", "kind": "angle"}}, "a signal of the joint itself"),
        ({"q2": {"name": "axis3", "kind": "angle"}}, 'there is no column "axis3"'),
    ],
)
def test_a_companion_that_is_none_is_refused(signals: dict[str, dict[str, str]], words: str) -> None:
    with pytest.raises(rid.RobotidError) as caught:
        rid.read(motor_log() | {"axis2": np.linspace(0.0, 1.0, 2000)}, signals=signals)
    assert words in str(caught.value)
