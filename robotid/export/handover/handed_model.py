"""A fitted model on its way to another program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from robotid.catalogue import assemble
from robotid.estimate.fitted_model import FittedModel, fitted_model
from robotid.estimate.result import FitResult
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.structure import Structure
from robotid.model.units import on_axis
from robotid.signals.record import Record

SLOW = 1e-3  # of the speed of the records: below it a simulator may take a joint for at rest
SLOW_UNKNOWN = 1e-2  # [rad/s] of the motor, where no record is known


@dataclass(frozen=True, eq=False)
class HandedModel:
    """A fit, and what a file for another program needs to know besides.

    robot : its name; records : those that show what is lost, where they are known. joint_name : of the joint in the
    other program; file_stem : of the file that is written; patched : text of the file into which it is written, where
    one is given.
    """

    robot: str
    fit: FitResult
    estimate_states: bool = True
    records: tuple[Record, ...] = ()
    joint_name: str = ""
    file_stem: str = "joint"
    patched: str = ""

    @cached_property
    def joint(self) -> Joint:
        """The joint with its angle among its states."""
        return assemble(self.fit.structure, angle=True)

    @property
    def theta(self) -> Array:
        """Its parameters, in the order of the joint; changes of single records are left out."""
        values = np.array([p.value for p in self.fit.parameters])
        return self.joint.in_record(values, "")

    @property
    def model(self) -> FittedModel:
        """The model as it is simulated here."""
        return fitted_model(self.fit, estimate_states=self.estimate_states)

    @property
    def slow_speed(self) -> float:
        """A motor speed that is next to rest [rad/s]."""
        speeds = [float(np.sqrt(np.mean(r.dphi_m**2))) for r in self.records]
        return SLOW * float(np.median(speeds)) if any(speeds) else SLOW_UNKNOWN

    def unit(self, unit: str) -> str:
        """What a unit of a turning axis is called here."""
        return on_axis(linear=self.fit.structure.linear)(unit)

    def without(self, effects: Mapping[str, str]) -> HandedModel:
        """The same model without some effects."""
        structure = self.fit.structure
        for effect in effects:
            structure = structure.without(effect)
        return self.with_structure(structure, {})

    def with_structure(self, structure: Structure, values: Mapping[str, float]) -> HandedModel:
        """A model of other effects: parameters of the same name keep their values, the others have these."""
        known = {p.name: p for p in self.fit.parameters}
        fresh = assemble(structure).parameters()
        estimates = tuple(
            replace(known[name], value=values.get(name, known[name].value))
            if name in known
            else replace(next(iter(known.values())), name=name, value=values.get(name, float(guess)), unit=unit)
            for name, unit, guess in zip(fresh.names, fresh.units, fresh.values, strict=True)
        )
        fit = replace(self.fit, structure=structure, parameters=estimates, initial_states={})
        return replace(self, fit=fit)


@dataclass(frozen=True, slots=True)
class Cost:
    """What a record loses where effects are left out: the fit [%] of the whole model and of the one handed over, None
    where that diverges; difference : RMS of their outputs."""

    record: str
    before: float
    after: float | None
    difference: float | None
    unit: str


@dataclass(frozen=True, slots=True)
class HandOver:
    """A file for another program. omitted : effects that it cannot express, and why; costs : by record; remarks : what
    whoever uses it should know."""

    text: str
    omitted: Mapping[str, str]
    costs: tuple[Cost, ...] = ()
    remarks: tuple[str, ...] = field(default=())
