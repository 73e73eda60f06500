"""Artifacts whose arrays, names and lengths do not belong together are refused when they are loaded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, get_args, get_type_hints

import numpy as np
import pytest

import robotid as rid
from robotid.artifacts.codec import _resolve
from robotid.artifacts.consistency import mismatches
from robotid.estimate.result import End, Estimate, FitResult, Fits
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.pipeline.table import STAGES
from robotid.signals.frf import Frf
from robotid.signals.quality import Recordings, inspect
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.signals.trace import Trace
from robotid.validation.residual_tests import residual_test


@dataclass(frozen=True, slots=True, eq=False)
class Inner:
    y: Array = field(metadata={"shape": ("n",)})


@dataclass(frozen=True, slots=True, eq=False)
class Outer:
    x: Array = field(metadata={"shape": ("n",)})
    square: Array = field(metadata={"shape": ("n", "n"), "may_be_empty": True})
    same: Inner
    traces: dict[str, Inner] = field(metadata={"lengths": {"n": "k[]"}})
    beside: dict[str, Array] = field(metadata={"shape": ("k[]",)})
    best: str = field(metadata={"among": "traces"})


WHOLE = Outer(
    np.zeros(2),
    np.zeros((2, 2)),
    Inner(np.zeros(2)),
    {"a": Inner(np.zeros(5)), "b": Inner(np.zeros(6))},
    {"a": np.zeros(5), "b": np.zeros(6)},
    "a",
)


def test_what_belongs_together() -> None:
    assert list(mismatches(WHOLE)) == list(mismatches(replace(WHOLE, square=np.zeros((0, 0))))) == []


@pytest.mark.parametrize(
    "change",
    [
        {"square": np.zeros((2, 3))},
        {"square": np.zeros(4)},
        {"same": Inner(np.zeros(3))},
        {"beside": {"a": np.zeros(6)}},
        {"best": "c"},
    ],
    ids=str,
)
def test_what_does_not(change: dict[str, Any]) -> None:
    (text,) = mismatches(replace(WHOLE, **change))
    assert text.startswith(("Outer.", "Inner."))


def classes(hint: Any, seen: set[type[Any]]) -> Iterator[type[Any]]:
    """All dataclasses that a type holds."""
    kind = _resolve(hint)
    if isinstance(kind, type) and is_dataclass(kind):
        if kind not in seen:
            seen.add(kind)
            yield kind
            for inner in get_type_hints(kind).values():
                yield from classes(inner, seen)
    else:
        for inner in get_args(kind):
            yield from classes(inner, seen)


@dataclass(frozen=True, slots=True, eq=False)
class Numbers:
    plain: Array = field(default_factory=lambda: np.array([1.0, np.nan]))
    by_name: dict[str, float] = field(default_factory=lambda: {"a": 1.0}, metadata={"finite": True})
    pair: tuple[float, float] = field(default=(1.0, 2.0), metadata={"positive": True})
    free: float = field(default=np.inf, metadata={"unbounded": True, "least": 0.0})
    count: int | None = field(default=None, metadata={"least": 0.0})
    torque: complex = field(default=1j, metadata={"finite": True, "largest": 10.0})


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"plain": np.array([1.0, -np.inf])}, "plain is not finite"),
        ({"plain": np.array([1.0, -1e101])}, "plain is beyond 1e+100"),
        ({"by_name": {"a": 1.0, "b": np.nan}}, "by_name is not finite"),
        ({"by_name": {"a": 1e300}}, "by_name is beyond 1e+100"),
        ({"pair": (1.0, 1e-310)}, "pair is not positive"),
        ({"pair": (1.0, np.inf)}, "pair is not finite"),
        ({"free": -1.0}, "free is below 0"),
        ({"count": -1}, "count is below 0"),
        ({"torque": 11j}, "torque is beyond 10"),
    ],
    ids=str,
)
def test_numbers_that_cannot_be(change: dict[str, Any], what: str) -> None:
    assert list(mismatches(Numbers())) == list(mismatches(Numbers(free=1e300, count=0, plain=np.zeros(0)))) == []
    assert list(mismatches(replace(Numbers(), **change))) == [f"Numbers.{what}"]


def test_every_array_of_an_artifact_declares_its_lengths() -> None:
    seen: set[type[Any]] = set()
    found = [kind for stage in STAGES.values() for kind in classes(stage.type(), seen)]
    silent = [
        f"{kind.__name__}.{one.name}"
        for kind in found
        for one in fields(kind)
        if "ndarray" in repr(get_type_hints(kind)[one.name]).lower() and "shape" not in one.metadata
    ]
    assert len(found) > 30
    assert silent == []


def test_a_fit_of_another_joint() -> None:
    t = np.arange(400) * 0.01
    speed = 5 * np.sin(2 * t) + 3 * np.sin(5 * t)
    torque = 0.1 * np.gradient(speed, 0.01)
    record = Record.from_arrays(torque, np.cumsum(speed) * 0.01, 0.01, speed=speed, name="log")
    fit = rid.fit(rid.Model(motor=["inertia"]), record)
    assert list(mismatches(Fits({fit.name: fit}, fit.name))) == []
    other = replace(fit.parameters[0], name="motor.inertia.K")
    for wrong in (replace(fit, parameters=(other,)), replace(fit, initial_states={"log": np.zeros(7)})):
        assert [text for text in mismatches(wrong) if "not those of its joint" in text]
    assert [text for text in mismatches(replace(fit, records=("day2",))) if "not those of its records" in text]
    assert [text for text in mismatches(Fits({"m9": fit}, "m9")) if "another name" in text]


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"cost": np.array([1.0, np.inf])}, "FitResult.cost is not finite"),
        ({"cost": np.zeros(0)}, "FitResult.cost is empty"),
        ({"noise_std": {"log": -1.0}}, "FitResult.noise_std is below 0"),
        ({"covariance": np.array([[np.nan]])}, "FitResult.covariance is not finite"),
        ({"covariance_robust": np.array([[-1.0]])}, "a variance of m is negative"),
        ({"initial_states": {"log": np.array([1e300])}}, "FitResult.initial_states is beyond 1e+100"),
    ],
    ids=str,
)
def test_a_fit_of_impossible_numbers(change: dict[str, Any], what: str) -> None:
    estimate = Estimate("motor.inertia.J", 0.1, "kg m2", 0.01, 0.01, 0.0, np.inf)
    alone, start = np.ones((1, 1)), {"log": np.ones(1)}
    structure, percent = Structure(("motor.inertia",)), {"log": 90.0}
    fit = FitResult(
        "m",
        ("log",),
        "speed",
        structure,
        (estimate,),
        alone,
        alone,
        start,
        percent,
        percent,
        np.ones(3),
        2,
        End.STALLED,
        1.0,
    )
    assert list(mismatches(fit)) == []
    assert list(mismatches(replace(fit, **change))) == [what]


def test_estimates_that_are_none() -> None:
    fixed = Estimate("motor.inertia.J", 0.1, "kg m2", np.nan, np.nan, -np.inf, np.inf)
    assert list(mismatches(fixed)) == []
    assert list(mismatches(replace(fixed, value=np.nan))) == ["Estimate.value is not finite"]
    assert list(mismatches(replace(fixed, std_robust=-1.0))) == ["Estimate.std_robust is below 0"]


@pytest.mark.parametrize("name", ["autocorrelation", "crosscorrelation"])
def test_correlations_that_are_none(name: str) -> None:
    rng = np.random.default_rng(1)
    found = residual_test(rng.standard_normal(400), rng.standard_normal(400))
    assert list(mismatches(found)) == []
    spoilt = getattr(found, name).copy()
    spoilt[3] = np.nan
    assert list(mismatches(replace(found, **{name: spoilt}))) == [f"ResidualTest.{name} is not finite"]
    assert list(mismatches(residual_test(np.zeros(3), np.zeros(3)))) == []


def test_a_response_of_nothing() -> None:
    found = Frf("log", np.ones(2), np.array([0.0, 1j]), np.zeros(2))
    assert list(mismatches(found)) == []
    for response in (np.zeros(2, complex), np.array([1.0, 1e-310 + 0j])):
        assert list(mismatches(replace(found, response=response))) == ["the response of log is none"]


def test_times_that_do_not_rise() -> None:
    trace = Trace(np.arange(3.0), np.zeros(3), np.zeros(3), "rad")
    assert list(mismatches(trace)) == list(mismatches(swing("log"))) == []
    assert list(mismatches(replace(trace, t=trace.t[::-1]))) == ["the samples of a trace are not one after the other"]
    late = list(mismatches(replace(swing("log"), begin=1e20)))
    assert late == ["the samples of log are not one after the other in time"]


def swing(name: str) -> Record:
    return Record.from_arrays(-np.sin(np.arange(60.0)), np.sin(np.arange(60.0)), 0.1, name=name)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"tau_m": np.full(60, np.nan)}, "tau_m is not finite"),
        ({"dphi_m": np.full(60, -1e200)}, "dphi_m is beyond 1e+12"),
        ({"begin": np.inf}, "begin is not finite"),
        ({"sampling_time": 0.0}, "sampling_time is not positive"),
        ({"period": -1.0}, "period is not positive"),
        ({name: np.zeros(0) for name in ("tau_m", "phi_m", "dphi_m")}, "tau_m is empty"),
    ],
    ids=str,
)
def test_a_record_of_no_recording(change: dict[str, Any], what: str) -> None:
    assert list(mismatches(swing("log"))) == []
    assert f"Record.{what}" in list(mismatches(replace(swing("log"), **change)))


def test_a_reference_without_samples() -> None:
    whole = Reference("slow", 0.1, np.ones(3), "speed")
    assert list(mismatches(whole)) == []
    assert list(mismatches(replace(whole, ref=np.zeros(0)))) == ["Reference.ref is empty"]


def test_reports_of_other_records() -> None:
    records = swing("a"), swing("b")
    a, b = (inspect(record, record.name) for record in records)
    assert list(mismatches(Recordings(records, (a, b)))) == []
    assert list(mismatches(Recordings(records, (b, a)))) == ["the reports are not those of its records"]
    assert list(mismatches(Recordings(records[:1] * 2, (a, a)))) == ["two records have the same name"]
