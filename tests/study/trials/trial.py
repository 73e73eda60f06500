"""One trial: draw, hide, let the tool diagnose and extend from the files alone, and note what it said."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from study.plant.catalogue import EFFECTS, UNKNOWN
from study.plant.draw import Draw, draw
from study.plant.experiment import Recording
from study.trials.case import Case, Hidden
from study.trials.plan import SIZES, Spec
from study.trials.shape import correlation
from study.trials.sizing import Sized, cost, floor, sized
from study.trials.tool import diagnose, fit, heldout_rmse
from robotid.errors import RobotidError
from robotid.diagnosis.results import Diagnosis
from robotid.extension.results import Extension

ORACLE_OFF = 1.25  # RMS error of the oracle's model over the noise from which its fit has not found the truth

USUAL = 5.0  # noise standard deviations that an effect of the catalogue's size costs, or so


@dataclass(frozen=True, slots=True)
class Result:
    """What a trial came to, ready for JSON; nan where a thing was not reached.

    size, shape : by hidden effect. cost : of leaving the effect out. rmse : of the models without the effect, of the
    oracle, and extended, on held-out records [rad/s]; causes : effect and its class, in order. correlation : of the
    reported shape of an unknown effect. error : why the trial ended early.
    """

    key: str
    kind: str
    hidden: tuple[str, ...]
    asked: float
    size: dict[str, float] = field(default_factory=dict)
    shape: dict[str, dict[str, float]] = field(default_factory=dict)
    noise: float = float("nan")
    cost: float = float("nan")
    rmse: dict[str, float] = field(default_factory=dict)
    verdict: str = ""
    causes: tuple[tuple[str, tuple[str, ...]], ...] = ()
    found: dict[str, dict[str, float]] = field(default_factory=dict)
    along: str = ""
    correlation: float = float("nan")
    seconds: dict[str, float] = field(default_factory=dict)
    error: str = ""


def run(spec: Spec, folder: Path) -> Result:
    """The whole trial in a folder of its own. An error of the tool is part of the result."""
    reached = nothing = Result(spec.key, spec.kind, spec.names, SIZES.get(spec.size, 0.0))
    try:
        for result in _growing(nothing, spec, folder):
            reached = result
    except RobotidError as error:
        return replace(reached, error=f"{type(error).__name__}: {error}")
    return reached


def _growing(result: Result, spec: Spec, folder: Path) -> Iterator[Result]:
    """The result after each part of the trial."""
    begin = time.perf_counter()
    one = prepare(spec, result.asked, folder)
    hidden, noise = one.case.hidden, floor(one.case)
    rmse, seconds = {"base": one.base.rmse}, {"prepare": time.perf_counter() - begin}
    result = replace(
        result,
        size={h.name: h.size for h in hidden},
        shape={h.name: dict(h.shape) for h in hidden},
        noise=noise,
        cost=one.cost,
        rmse=rmse,
        seconds=seconds,
    )
    yield result
    rmse["oracle"] = _oracle(one)
    if rmse["oracle"] < ORACLE_OFF * noise:
        result = replace(result, noise=rmse["oracle"], cost=cost(one.base.rmse, rmse["oracle"]))
    yield result
    begin = time.perf_counter()
    diagnosis, extension = diagnose(one.base)
    seconds["tool"] = time.perf_counter() - begin
    rmse["extended"] = heldout_rmse(extension, one.case.samples("validate"))
    yield _with_shape(_as_said(result, diagnosis, extension), diagnosis, one)


def _as_said(result: Result, diagnosis: Diagnosis, extension: Extension) -> Result:
    values = {p.name: p.value for p in extension.fit.parameters}
    return replace(
        result,
        verdict=diagnosis.verdict,
        causes=tuple((c.effect, c.twins) for c in diagnosis.causes),
        found={e: {name: v for name, v in values.items() if name.startswith(e)} for e in extension.added},
    )


def _with_shape(result: Result, diagnosis: Diagnosis, one: Sized) -> Result:
    if result.kind != "unknown" or diagnosis.shape is None:
        return result
    fitted = {name: one.records[name] for name in one.case.samples("estimate")}
    likeness = correlation(diagnosis.shape, one.case.hidden[0], fitted)
    return replace(result, along=diagnosis.shape.along, correlation=likeness)


def _oracle(one: Sized) -> float:
    """RMS error on held-out records of the true structure, fitted from near the truth; nan where there is none."""
    if one.case.structure(true=True) == one.case.structure():
        return float("nan")
    try:
        return fit(one.base.run.loaded.path.with_name("oracle.yaml")).rmse
    except RobotidError:
        return float("nan")


def prepare(spec: Spec, asked: float, folder: Path) -> Sized:
    """The case of a trial, its effects sized, each alone."""
    rng = spec.rng()
    drawn = draw(rng)
    effects = [drawn_effect(name, rng) for name in spec.names]
    if len(effects) == 1:
        return alone(drawn, effects[0], asked, folder)
    each = [alone(drawn, one, asked, folder / one[0]).case.hidden for one in effects]
    case = Case(drawn, tuple(h for hidden in each for h in hidden))
    return _as_it_is(case, folder)


Drawn = tuple[str, float, float, Mapping[str, float]]
"""Name of an effect, size to start from, largest size, shape."""


def drawn_effect(name: str, rng: np.random.Generator) -> Drawn:
    """An effect of the catalogue, or an unknown one, with its shape."""
    if name in UNKNOWN:
        return name, UNKNOWN[name].size, np.inf, UNKNOWN[name].shape(rng)
    return name, EFFECTS[name].size, EFFECTS[name].largest, EFFECTS[name].shape(rng)


def alone(drawn: Draw, effect: Drawn, asked: float, folder: Path) -> Sized:
    """A machine with one effect of the size that costs what is asked."""
    name, start, largest, shape = effect
    return sized(lambda size: Case(drawn, (Hidden(name, size, shape),)), start * asked / USUAL, largest, asked, folder)


def _as_it_is(case: Case, folder: Path) -> Sized:
    records: dict[str, Recording] = case.write(folder / "records")
    fitted = fit(folder / "records" / "base.yaml")
    return Sized(case, records, fitted, cost(fitted.rmse, floor(case)))
