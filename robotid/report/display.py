"""How results show themselves in Python, by `robotid.display.Displayed`: one view for each kind of result.

Rooms above the report add views of what they define by `shows`.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Generic, TypeVar

from matplotlib.figure import Figure

from robotid.diagnosis.results import Diagnosis
from robotid.errors import ConfigError
from robotid.estimate.flexible import FlexResult
from robotid.estimate.result import Estimate, FitResult, Fits
from robotid.estimate.rigid import RigidResult
from robotid.extension.results import Extension
from robotid.model.array import Array
from robotid.model.units import on_axis, sliding
from robotid.numerals import fixed, number
from robotid.report import comparison
from robotid.report.comparison import RunComparison
from robotid.report.drawing.layout import intervals_figure
from robotid.report.figures import draw
from robotid.report.tables import check, diagnose, extend, fit, init_flex, init_rigid, validate
from robotid.report.tables.sliding import in_units_of_axis
from robotid.report.tables.table import Table
from robotid.report.tables.text import as_html, as_text
from robotid.signals.plausibility import Plausibility
from robotid.signals.quality import Recordings
from robotid.signals.record import SIGNALS, Record
from robotid.validation.results import Validation

T = TypeVar("T")
Columns = Mapping[str, Sequence[Any] | Array]
"""Columns of a data frame by name, all of one length."""


class View(Generic[T]):
    """What is shown of one kind of result. The methods are those that a kind may have; `tables` it must."""

    index = 1
    """How many columns of a data frame are its index."""

    def __init__(self, content: T) -> None:
        self.content = content

    @property
    def linear(self) -> bool:
        """Whether the axis slides rather than turns."""
        return False

    def line(self) -> str:
        """The result in a few words."""
        return ""

    def tables(self) -> Sequence[Table]:
        """All tables."""
        raise NotImplementedError

    def brief(self) -> Sequence[Table]:
        """The most important ones."""
        return self.tables()

    def columns(self) -> Columns:
        """What a data frame holds. Raises ConfigError where there is nothing to list."""
        raise ConfigError("this result has no numbers to list", hint="print its table instead")

    def figure(self) -> Figure:
        """The figure. Raises ConfigError where there is nothing to see."""
        return draw(self.content, on_axis(linear=self.linear))


VIEWS: dict[type, type[View[Any]]] = {}
"""The view of each kind of result; a kind without one is shown as that from which it is derived."""

V = TypeVar("V", bound=type[View[Any]])


def shows(kind: type) -> Callable[[V], V]:
    """Make a class the view of a kind of result."""
    return partial(_add, kind)


def _add(kind: type, view: V) -> V:
    VIEWS[kind] = view
    return view


def view_of(content: object) -> View[Any]:
    """The view of a result. Raises ConfigError where it has none."""
    for kind in type(content).__mro__:
        if kind in VIEWS:
            return VIEWS[kind](content)
    raise ConfigError("this is not a result that can be shown")


def line(content: object) -> str:
    """A result in a line."""
    line = view_of(content).line()
    return f"<{type(content).__name__}{': ' if line else ''}{line}>"


def text(content: object, *, brief: bool) -> str:
    """The tables of a result as plain text."""
    return as_text(_tables(content, brief=brief))


def html(content: object) -> str:
    """The most important tables of a result as HTML."""
    return as_html(_tables(content, brief=True))


def frame(content: object) -> Any:
    """The numbers of a result as a pandas data frame. Raises ConfigError where pandas is not installed."""
    view = view_of(content)
    columns = view.columns()
    try:
        pandas = importlib.import_module("pandas")
    except ImportError as error:
        raise ConfigError("a data frame needs pandas", hint="pip install 'robotid[pandas]'") from error
    return pandas.DataFrame(dict(columns)).set_index(list(columns)[: view.index])


def figure(content: object) -> Figure:
    """The figure of a result."""
    return view_of(content).figure()


def _tables(content: object, *, brief: bool) -> list[Table]:
    view = view_of(content)
    return [in_units_of_axis(table, linear=view.linear) for table in (view.brief() if brief else view.tables())]


def estimate_columns(estimates: Sequence[Estimate]) -> Columns:
    """Parameters with their uncertainty, a row each."""
    names = ("name", "value", "std", "std_robust", "unit", "lower", "upper", "fixed", "remark")
    return {"parameter" if n == "name" else n: [getattr(p, n) for p in estimates] for n in names}


@shows(Record)
class RecordView(View[Record]):
    """A record: its size and ranges, its signals."""

    def line(self) -> str:
        r = self.content
        return f"{r.name} ({r.role}), {len(r)} samples at {1 / r.sampling_time:g} Hz, {r.duration:g} s"

    def tables(self) -> Sequence[Table]:
        r = self.content
        signals = {"tau_m": "Nm", "phi_m": "rad", "dphi_m": "rad/s", "phi_a": "rad", "ref": ""}
        present = {name: values for name in signals if (values := getattr(r, name)) is not None}
        present |= {name: one.values for name, one in r.companions.items()}
        signals |= {name: one.unit for name, one in r.companions.items()}
        rows = tuple(
            (name, number(float(v.min())), number(float(v.max())), signals[name]) for name, v in present.items()
        )
        return (Table(self.line(), ("signal", "least", "largest", "unit"), rows),)

    def columns(self) -> Columns:
        r = self.content
        signals = {name: getattr(r, name) for name in ("t", *SIGNALS)}
        signals |= {name: one.values for name, one in r.companions.items()}
        return {name: values for name, values in signals.items() if values is not None}

    def figure(self) -> Figure:
        return draw(Recordings((self.content,)))


@shows(Plausibility)
class PlausibilityView(View[Plausibility]):
    """What the checks of records found."""

    def line(self) -> str:
        return check.sentence(self.content)

    def tables(self) -> Sequence[Table]:
        return check.tables(self.content)

    def columns(self) -> Columns:
        found = self.content.findings
        names = ("record", "name", "severity", "what", "consequence", "cure", "accepted")
        return {name: [getattr(finding, name) for finding in found] for name in names}


@shows(RigidResult)
class RigidView(View[RigidResult]):
    """Step 1."""

    def line(self) -> str:
        return f"{len(self.content.parameters)} parameters, condition number {number(self.content.condition_number, 3)}"

    def tables(self) -> Sequence[Table]:
        return init_rigid.tables(self.content)

    def columns(self) -> Columns:
        return estimate_columns(self.content.parameters)


@shows(FlexResult)
class FlexibleView(View[FlexResult]):
    """Step 2."""

    def line(self) -> str:
        return f"{len(self.content.frfs)} frequency responses"

    def tables(self) -> Sequence[Table]:
        return init_flex.tables(self.content)

    def columns(self) -> Columns:
        return estimate_columns(self.content.parameters)


@shows(FitResult)
class FitView(View[FitResult]):
    """One fitted model."""

    @property
    def linear(self) -> bool:
        return self.content.structure.linear

    @property
    def fits(self) -> Fits:
        """The model as the only one of a stage."""
        return Fits({self.content.name: self.content}, self.content.name)

    def line(self) -> str:
        levels = ", ".join(f"{name} {fixed(percent)} %" for name, percent in self.content.fit_percent.items())
        return f"{self.content.name}, {len(self.content.parameters)} parameters, fit of {levels}; {self.content.end}"

    def tables(self) -> Sequence[Table]:
        return [replace(table, note="") if table.title == "Fits" else table for table in fit.tables(self.fits)]

    def columns(self) -> Columns:
        return estimate_columns(self.content.parameters)

    def figure(self) -> Figure:
        return draw(self.fits, on_axis(linear=self.linear))


@shows(Validation)
class ValidationView(View[Validation]):
    """Models on all records."""

    index = 2

    @property
    def linear(self) -> bool:
        return self.content.models[self.content.best].structure.linear

    def line(self) -> str:
        records = self.content.models[self.content.best].records
        levels = ", ".join(f"{name} {fixed(r.fit_percent)} %" for name, r in records.items())
        return f"{self.content.best} fits {levels}"

    def tables(self) -> Sequence[Table]:
        return validate.tables(self.content)

    def columns(self) -> Columns:
        found = [
            (model, name, r.role, r.used, r.fit_percent, r.rmse_speed, r.rmse_position, r.torque_error_percent)
            for model, one in self.content.models.items()
            for name, r in one.records.items()
        ]
        heads = ("model", "record", "role", "used", "fit_percent", "rmse_speed", "rmse_position")
        return dict(zip((*heads, "torque_error_percent"), map(list, zip(*found, strict=True)), strict=True))


@shows(Diagnosis)
class DiagnosisView(View[Diagnosis]):
    """The verdict on a model."""

    @property
    def linear(self) -> bool:
        return self.content.unit == sliding(self.content.unit)

    def line(self) -> str:
        return f"{self.content.verdict}; {diagnose.sentence(self.content)}"

    def tables(self) -> Sequence[Table]:
        return diagnose.tables(self.content)

    def brief(self) -> Sequence[Table]:
        return diagnose.brief(self.content)

    def columns(self) -> Columns:
        causes = self.content.causes
        return {
            "effect": [c.effect for c in causes],
            "explained": [c.explained for c in causes],
            "heldout_gain": [c.heldout_gain for c in causes],
            "p_value": [c.p_value for c in causes],
            "confounded_with": [", ".join(one.effect for one in c.confounded_with) for c in causes],
            "class": [", ".join(c.twins) for c in causes],
            "parameters": [{p.name.removeprefix(f"{c.effect}."): p.value for p in c.parameters} for c in causes],
        }


@shows(Extension)
class ExtensionView(View[Extension]):
    """A model before and after its extension."""

    @property
    def linear(self) -> bool:
        return self.content.fit.structure.linear

    def line(self) -> str:
        return extend.sentence(self.content)

    def tables(self) -> Sequence[Table]:
        first, *others = extend.tables(self.content)
        return [replace(first, note=""), *others]

    def brief(self) -> Sequence[Table]:
        return self.tables()[: len(extend.brief(self.content)) or 1]

    def columns(self) -> Columns:
        e = self.content
        names = [name for name in e.before if name in e.after]
        return {
            "record": names,
            "used": [e.after[n].used for n in names],
            "fit_before": [e.before[n].fit_percent for n in names],
            "fit_after": [e.after[n].fit_percent for n in names],
            "rmse_before": [e.before[n].rmse for n in names],
            "rmse_after": [e.after[n].rmse for n in names],
        }


@shows(RunComparison)
class ComparisonView(View[RunComparison]):
    """Fits side by side."""

    index = 2

    @property
    def linear(self) -> bool:
        return self.content.linear

    def line(self) -> str:
        return comparison.sentence(self.content)

    def tables(self) -> Sequence[Table]:
        return comparison.tables(self.content)

    def columns(self) -> Columns:
        names = ("parameter", "run", "value", "std", "p_value", "differs")
        found = self.content.fits.differences
        return {"difference" if name == "value" else name: [getattr(one, name) for one in found] for name in names}

    def figure(self) -> Figure:
        return intervals_figure(self.content.fits.fits, on_axis(linear=self.linear))
