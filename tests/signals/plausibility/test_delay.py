"""The delay of a torque that another device recorded, and the setting that takes it out."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import scipy
from support.diagnosed_run import configuration
from support.mistaken_logs import FLEXIBLE, RATIO, RIGID, H, Log, log_of, swing
from support.paper_joint import STRUCTURE, TRUTH

from robotid.artifacts.store import load
from robotid.catalogue import assemble
from robotid.cli.app import main
from robotid.model.array import Array
from robotid.signals.measured import Selection, measured_records
from robotid.signals.plausibility import Axis, check_records, delay
from robotid.signals.plausibility.delay import torque_delay
from robotid.signals.quality import Recordings, inspect
from robotid.signals.readers.table import Table
from robotid.signals.record import Record
from robotid.signals.resampling import mean_over_intervals
from robotid.simulation.simulate import simulate

EDGE = 25


@cache
def log(kind: str) -> Log:
    return log_of(RIGID, swing()) if kind == "rigid" else log_of(FLEXIBLE, swing(), ratio=RATIO)


def late_log(samples: float, kind: str = "rigid") -> Log:
    """A log whose torque was recorded late by some samples, its ends cut."""
    given = log(kind)
    n = len(given["t"])
    kept = slice(EDGE, n - EDGE)
    torque: Array = mean_over_intervals(np.arange(n) * 1.0, given["tau_m"], np.arange(EDGE, n - EDGE) - samples)
    return {name: values[kept] for name, values in given.items()} | {"tau_m": torque}


def record(columns: Log) -> Record:
    return Record.from_arrays(columns["tau_m"], columns["phi_m"], H, speed=columns["dphi_m"], name="log")


@pytest.mark.parametrize("samples", [0.0, 0.4, 1.0, -2.3, 6.0])
def test_the_delay_is_found_to_a_fraction_of_a_sample(samples: float) -> None:
    found = torque_delay(record(late_log(samples)))
    assert found.value / H == pytest.approx(samples, abs=0.02)
    assert found.std / H < 0.02


def test_of_a_long_record_stretches_tell_the_delay(monkeypatch: pytest.MonkeyPatch) -> None:
    whole, seen = record(late_log(0.4)), list[int]()
    at = delay._Lag.at
    monkeypatch.setattr(delay, "DELAY", replace(delay.DELAY, max_samples=len(whole) // 2))
    monkeypatch.setattr(delay._Lag, "at", lambda part, *by, **how: (seen.append(len(part)), at(part, *by, **how))[1])
    found = torque_delay(whole)
    assert max(seen) == len(whole) // 10
    assert found.value / H == pytest.approx(0.4, abs=max(0.1, 3 * found.std / H))


def test_a_joint_that_flexes_tells_no_delay_of_less_than_its_deviation() -> None:
    found = torque_delay(record(late_log(0.0, "flexible")))
    assert abs(found.ratio) < 3.0


@cache
def damped_gear() -> Record:
    """The publication's joint with a stiffer and more damped gear, its notch at 20 Hz, moved up to 8 Hz."""
    h, n = 1e-3, 24_000
    low = scipy.signal.butter(4, 8.0, fs=1.0 / h, output="sos")
    torque = scipy.signal.sosfilt(low, np.random.default_rng(1).standard_normal(n))
    torque *= 5.0 / float(np.std(torque))
    joint = assemble(STRUCTURE)
    gear = {"gear.spring.k1": 18e6, "gear.cubic_spring.k3": 0.0, "gear.damper.d": 3e4}
    theta = joint.parameters().with_values(TRUTH | gear).values
    speed = simulate(
        joint, theta, Record("gear", "estimate", "both", h, torque, 0 * torque, 0 * torque), np.zeros(3)
    ).dphi_m
    angle = scipy.integrate.cumulative_trapezoid(speed, dx=h, initial=0.0)
    return Record.from_arrays(torque, angle, h, speed=speed, name="gear")


def test_the_damper_of_a_gear_is_no_delay() -> None:
    one = damped_gear()
    assert torque_delay(one, rigid=True).ratio > 5.0
    assert abs(torque_delay(one).ratio) < 3.0


def test_a_delay_is_found_beside_the_damper_of_a_gear() -> None:
    found = torque_delay(replace(damped_gear(), tau_m=np.roll(damped_gear().tau_m, 3)))
    assert found.ratio > 5.0
    assert found.value / 1e-3 == pytest.approx(3.0, abs=3.0 * found.std / 1e-3)


@cache
def axis_records(case: str) -> tuple[Record, ...]:
    """Records of a rigid axis that reverses, "named" with a Stribeck effect and "clean" without."""
    with TemporaryDirectory(prefix="robotid-") as folder:
        config, out = Path(folder, "axis.yaml"), Path(folder, "out")
        config.write_text(configuration(case), encoding="utf-8")
        for stage in ("excite", "collect"):
            assert main([stage, str(config), "--out", str(out), "--quiet"]) == 0
        return load(out / "records.h5", Recordings).content.records


@pytest.mark.parametrize("case", ["named", "clean"])
def test_friction_about_a_reversal_is_no_delay(case: str) -> None:
    for one in axis_records(case):
        assert abs(torque_delay(one).ratio) < 3.0, one.name


@pytest.mark.parametrize("case", ["named", "clean"])
def test_a_delay_is_found_beside_friction_about_a_reversal(case: str) -> None:
    wide = axis_records(case)[1]
    found = torque_delay(replace(wide, tau_m=np.roll(wide.tau_m, 2)))
    assert found.ratio > 10.0
    assert found.value / wide.sampling_time == pytest.approx(2.0, abs=3.0 * found.std / wide.sampling_time)


def test_a_short_record_tells_none() -> None:
    short = record(late_log(1.0)).piece(0, 15)
    assert torque_delay(short).std == np.inf


@pytest.mark.parametrize(("samples", "direction"), [(1.5, "late"), (-3.0, "early")])
def test_a_delay_is_reported_with_the_setting_that_takes_it_out(samples: float, direction: str) -> None:
    one = record(late_log(samples))
    (finding,) = check_records(Recordings((one,), (inspect(one, "log"),)), Axis()).findings
    assert (finding.name, finding.severity) == ("torque_late", "warning")
    assert f"({abs(samples):g} samples) {direction}" in finding.what
    assert f"set torque_delay: {samples * H:.2g}" in finding.cure


@pytest.mark.parametrize("samples", [2.0, -3.0, 1.5])
def test_the_setting_takes_it_out(samples: float) -> None:
    columns = late_log(samples)
    columns["t"] = columns["t"] - columns["t"][0]
    ((found, _),) = measured_records(Selection("log", torque_delay=samples * H), Table("log", columns))
    assert abs(torque_delay(found).value) < 0.02 * H
    lost = int(np.ceil(abs(samples)))
    assert len(found) == len(columns["t"]) - lost
    first = lost if samples < 0 else 0
    np.testing.assert_array_equal(found.phi_m, columns["phi_m"][first : first + len(found)])
    if samples == round(samples):
        true = log("rigid")["tau_m"][EDGE + first : EDGE + first + len(found)]
        assert found.tau_m == pytest.approx(true, abs=1e-9)


def test_without_a_delay_nothing_is_cut() -> None:
    columns = late_log(0.0)
    columns["t"] = columns["t"] - columns["t"][0]
    ((plain, _),) = measured_records(Selection("log"), Table("log", columns))
    assert len(plain) == len(columns["t"])
    np.testing.assert_array_equal(plain.tau_m, columns["tau_m"])
