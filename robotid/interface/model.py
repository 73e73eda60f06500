"""What a person says of a joint: which effects act where, and what is known of their parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

from robotid.catalogue import EFFECTS, assemble
from robotid.config.load import from_plain
from robotid.config.schema import Config
from robotid.config.suggest import suggest
from robotid.display import Displayed
from robotid.errors import ConfigError
from robotid.model.companion import companion_of
from robotid.model.describe import describe
from robotid.model.parameters import KnownParameter
from robotid.model.port import Port, Signal
from robotid.model.structure import RECORD_CHANGE, Structure, changed
from robotid.numerals import number
from robotid.report.display import Columns, View, shows
from robotid.report.tables.table import Table

PLACES = (*map(str, Port), *map(str, Signal))
SOME_RECORD = {"name": "record", "file": "record.csv"}
"""A model is checked as a configuration is, and that has a record."""


@dataclass(frozen=True, slots=True, repr=False)
class Model(Displayed):
    """A joint to be identified: its effects by place, and what is known of their parameters.

    motor, gear, arm, link, tool : names of effects at these ports, such as "inertia", "viscous", "coulomb", "spring";
    one that reads a companion of the records names it, such as "pose_inertia[q2]";
    torque, angle, speed : names of effects on these signals, such as "torque_delay". `rid.explain()` lists them all.
    gear_ratio : phi_a / phi_m, arm angle over motor angle, at most 1; None for a rigid axis that is its motor alone.
    linear : the axis slides (m, N, kg) rather than turns. recorded_angle : torques that depend on the motor's angle act
    at the recorded angle of a record, for that of an open-loop simulation drifts. name : of the robot.
    changes : by record, parameters that differ there.
    known : by dotted name what is known beforehand, in SI; a plain number is a guess.

    Raises ConfigError for what does not fit together: an effect that does not exist or cannot act there, a mass without
    inertia, a parameter that the model has not.

    >>> import robotid as rid
    >>> model = rid.Model(motor=["inertia", "viscous", "coulomb"])
    >>> model.parameters
    ('motor.inertia.J', 'motor.viscous.Fv', 'motor.coulomb.Fc')
    >>> rid.Model(motor=["inertia", "viscos"])
    Traceback (most recent call last):
    ...
    robotid.errors.ConfigError: Model, motor[1]: there is no effect "viscos"; did you mean viscous?
    """

    motor: Sequence[str] = ()
    gear: Sequence[str] = ()
    arm: Sequence[str] = ()
    link: Sequence[str] = ()
    tool: Sequence[str] = ()
    torque: Sequence[str] = ()
    angle: Sequence[str] = ()
    speed: Sequence[str] = ()
    gear_ratio: float | None = None
    linear: bool = False
    recorded_angle: bool = False
    name: str = "robot"
    changes: Mapping[str, Sequence[str]] = field(default_factory=dict)
    known: Mapping[str, KnownParameter | float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for place in PLACES:
            object.__setattr__(self, place, _names(place, getattr(self, place)))
        object.__setattr__(self, "known", {name: _known(name, one) for name, one in self.known.items()})
        changes = {record: _names("changes", names) for record, names in self.changes.items()}
        object.__setattr__(self, "changes", changes)
        records = [{"name": name, "file": "record.csv"} for name in changes] or [SOME_RECORD]
        self.configuration(records)

    @property
    def structure(self) -> Structure:
        """Dotted names of the effects, in order."""
        return self.configuration([{"name": r, "file": "-"} for r in self.changes] or [SOME_RECORD]).structure()

    @property
    def parameters(self) -> tuple[str, ...]:
        """Dotted names of the parameters, in order."""
        return assemble(self.structure).names

    @property
    def knowledge(self) -> dict[str, KnownParameter]:
        """What is known of the parameters beforehand, by dotted name."""
        return {name: _known(name, one) for name, one in self.known.items()}

    def with_effects(self, *effects: str) -> Model:
        """The same joint with further effects, by dotted name: `model.with_effects("motor.stribeck")`. Raises
        ConfigError where the model cannot have one."""
        more = self
        for effect in effects:
            place, dot, name = effect.partition(".")
            if place == RECORD_CHANGE:
                record, parameter = changed(effect)
                changes = {**more.changes, record: (*more.changes.get(record, ()), parameter)}
                more = replace(more, changes=changes)
                continue
            if place not in PLACES or not dot:
                hint = suggest(place, PLACES) if dot else "write it as port.effect, such as motor.stribeck"
                raise ConfigError(f'"{effect}" names no place where an effect acts', where="Model", hint=hint)
            more = replace(more, **{place: (*getattr(more, place), name)})  # type: ignore[arg-type]
        return more

    def with_known(
        self,
        guesses: Mapping[str, float] | None = None,
        bounds: Mapping[str, tuple[float, float]] | None = None,
        fixed: Iterable[str] | Mapping[str, float] = (),
    ) -> Model:
        """The same joint, with more known of its parameters, in SI, by dotted name.

        guesses : where the fit starts, instead of what the initialisation finds. bounds : lower and upper. fixed :
        names that are not estimated and keep what the initialisation finds, or names with the values that they keep.
        Raises ConfigError for a parameter that the model has not.

        >>> import robotid as rid
        >>> model = rid.Model(motor=["inertia", "viscous"]).with_known(fixed={"motor.inertia.J": 0.01})
        >>> model.known["motor.inertia.J"]
        KnownParameter(guess=0.01, bounds=None, fixed=True)
        """
        values = {name: float(value) for name, value in fixed.items()} if isinstance(fixed, Mapping) else {}
        known = dict(self.known)
        for name in fixed if not isinstance(fixed, str) else [fixed]:
            known[name] = replace(_known(name, known.get(name)), fixed=True)
        for name, value in {**(guesses or {}), **values}.items():
            known[name] = replace(_known(name, known.get(name)), guess=float(value))
        for name, pair in (bounds or {}).items():
            known[name] = replace(_known(name, known.get(name)), bounds=_pair(name, pair))
        return replace(self, known=known)

    def _signals(self) -> dict[str, dict[str, str]]:
        """What the effects of this model read beside torque and motion, as a configuration declares it."""
        effects = (companion_of(name) for place in PLACES for name in getattr(self, place))
        read = {signal: EFFECTS[name].companion for name, signal in effects if signal and name in EFFECTS}
        return {signal: {"name": signal, "kind": str(kind)} for signal, kind in read.items() if kind is not None}

    def configuration(self, records: Sequence[Mapping[str, Any]], **sections: Mapping[str, Any]) -> Config:
        """The complete configuration of this model, with these records and further sections. Raises ConfigError."""
        effects = {place: list(getattr(self, place)) for place in PLACES if getattr(self, place)}
        robot: dict[str, Any] = {"name": self.name, "model": effects, "linear": self.linear}
        if self.recorded_angle:
            robot["recorded_angle"] = True
        if self.gear_ratio is not None:
            robot["gear_ratio"] = self.gear_ratio
        if self.changes:
            robot["changes"] = {record: list(names) for record, names in self.changes.items()}
        if self.known:
            robot["parameters"] = {name: _as_settings(_known(name, one)) for name, one in self.known.items()}
        signals = self._signals()
        made = [{**record, "signals": signals | dict(record.get("signals", {}))} for record in records]
        try:
            return from_plain({"robot": robot, "records": made, **sections})
        except ConfigError as error:
            raise ConfigError(error.what, where=_place(error.where), hint=_in_python(error.hint)) from None


def model_of(config: Config) -> Model:
    """The model of a configuration."""
    robot = config.robot
    return Model(
        gear_ratio=robot.gear_ratio,
        linear=robot.linear,
        recorded_angle=robot.recorded_angle,
        name=robot.name,
        changes=robot.changes,
        known=robot.known(),
        **robot.model,
    )


def _names(place: str, names: Any) -> tuple[str, ...]:
    """Names of effects as a tuple; one name alone is a list of one."""
    listed = (names,) if isinstance(names, str) else tuple(names)
    if not all(isinstance(name, str) for name in listed):
        raise ConfigError(
            f"{place} is a list of names of effects", where="Model", hint='such as ["inertia", "viscous"]'
        )
    return listed


def _known(name: str, one: KnownParameter | float | None) -> KnownParameter:
    if one is None or isinstance(one, KnownParameter):
        return one or KnownParameter()
    try:
        return KnownParameter(guess=float(one))
    except (TypeError, ValueError):
        hint = "give a number, or rid.KnownParameter(guess=..., bounds=..., fixed=...)"
        raise ConfigError(f"{one!r} is no value of {name}", where="Model", hint=hint) from None


def _pair(name: str, bounds: Any) -> tuple[float, float]:
    try:
        lower, upper = bounds
        return float(lower), float(upper)
    except (TypeError, ValueError):
        raise ConfigError(f"{bounds!r} are no bounds of {name}", where="Model", hint="give (lower, upper)") from None


def _as_settings(known: KnownParameter) -> dict[str, Any]:
    given = {f.name: value for f in fields(known) if (value := getattr(known, f.name)) not in (None, False)}
    return given | ({"bounds": list(known.bounds)} if known.bounds is not None else {})


def _place(where: str) -> str:
    """Where in the call an error is: "configuration:3  robot.model.motor[1]" is Model, motor[1]."""
    path = where.rpartition("  ")[2].removeprefix("robot.").removeprefix("model.").removeprefix("model")
    return f"Model, {path.replace('parameters.', 'known ')}" if path else "Model"


def _in_python(hint: str) -> str:
    return (
        hint.replace("add gear_ratio: phi_a / phi_m", "give gear_ratio=phi_a / phi_m")
        .replace("`robotid explain` lists them all", "rid.explain() lists them all")
        .replace("robot.gear_ratio", "gear_ratio")
    )


@shows(Model)
class ModelView(View[Model]):
    """The effects of a model and their parameters."""

    @property
    def linear(self) -> bool:
        return self.content.linear

    def line(self) -> str:
        places = (f"{place} {', '.join(names)}" for place in PLACES if (names := getattr(self.content, place)))
        return "; ".join(places)

    def tables(self) -> Sequence[Table]:
        joint, known = assemble(self.content.structure), self.content.known
        formulas = {f"{place}.{effect.name}": describe(effect).formula for place, effect in joint.terms}
        formulas |= {f"{place}.{effect.name}": describe(effect).formula for place, effect in joint.channels}
        rows = []
        for name, declared, unit in zip(joint.names, joint.declared, joint.parameters().units, strict=True):
            one = _known(name, known.get(name))
            state = "fixed" if one.fixed else "guess" if one.guess is not None else ""
            rows.append((name, unit, number(one.guess), state, declared.meaning))
        effects = tuple((name, formula) for name, formula in formulas.items())
        columns = ("parameter", "unit", "known", "as", "meaning")
        return Table(self.content.name, ("effect", "formula"), effects), Table("", columns, tuple(rows))

    def columns(self) -> Columns:
        joint, known = assemble(self.content.structure), self.content.known
        given = [_known(name, known.get(name)) for name in joint.names]
        return {
            "parameter": joint.names,
            "unit": joint.parameters().units,
            "guess": [one.guess for one in given],
            "fixed": [one.fixed for one in given],
            "meaning": [p.meaning for p in joint.declared],
        }
