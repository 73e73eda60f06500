"""One case: a drawn machine with something hidden in it, as records and configurations in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from study.plant.catalogue import CHANGED, EFFECTS, UNKNOWN
from study.plant.draw import Draw
from study.plant.experiment import Recording
from study.plant.files import BASE, write_config, write_csv
from study.plant.rig import Rig
from study.plant.strangers import EVENTFUL, STRANGERS
from robotid.channels import CHANNELS
from robotid.terms import TERMS

KNOWN_INERTIA = "torque.torque_gain"
"""The effect that shows only beside a known inertia, which the configuration then fixes."""


@dataclass(frozen=True, slots=True)
class Hidden:
    """An effect of the plant's catalogue, or an unknown one, with its size (a positive number, SI) and shape."""

    name: str
    size: float
    shape: Mapping[str, float]

    def into(self, rig: Rig, record: str) -> Rig:
        """The rig with the effect, where it is there on this record."""
        if self.name in STRANGERS:
            stranger = STRANGERS[self.name]
            return rig if stranger.event and record != EVENTFUL else stranger.build(rig, self.size, self.shape)
        if self.name in UNKNOWN:
            law = UNKNOWN[self.name].law(self.size, self.shape)
            return replace(rig, extra=rig.extra.with_motor(law))
        if self.name.startswith("record_change") and record != CHANGED:
            return rig
        return EFFECTS[self.name].build(rig, self.size * self.shape["sign"], self.shape)

    def truth(self) -> dict[str, float]:
        """Values of the tool's parameters by their full names, as far as the tool has such parameters."""
        if self.name in UNKNOWN or self.name in STRANGERS or self.name.startswith("record_change"):
            return {}
        effect = EFFECTS[self.name]
        values = effect.truth(self.size * self.shape["sign"], self.shape)
        known = (TERMS | CHANNELS)[self.name.partition(".")[2]].parameters
        return {f"{self.name}.{p.symbol}": values[p.symbol] for p in known if p.symbol in values}


@dataclass(frozen=True, slots=True)
class Case:
    """A drawn machine and what is hidden in it."""

    draw: Draw
    hidden: tuple[Hidden, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of what is hidden."""
        return tuple(h.name for h in self.hidden)

    def structure(self, *, true: bool = False) -> tuple[str, ...]:
        """Effects that the tool is told of: the base's without what is hidden, or all."""
        cubic = ("gear.cubic_spring",) if self.draw.base.k3 else ()
        told = tuple(e for e in (*BASE, *cubic) if e not in self.names)
        return (*told, *(n for n in self.names if n not in UNKNOWN and n not in STRANGERS)) if true else told

    def samples(self, role: str) -> dict[str, int]:
        """Lengths of the records of a role, by name."""
        return {
            plan.name: len(plan.ref[:: self.draw.condition.every]) for plan in self.draw.plans if plan.role == role
        }

    def records(self) -> dict[str, Recording]:
        """Every record of the plan, by name. Seconds each."""
        made: dict[str, Recording] = {}
        for number, plan in enumerate(self.draw.plans):
            rig = Rig(self.draw.base)
            for hidden in self.hidden:
                rig = hidden.into(rig, plan.name)
            made[plan.name] = self.draw.record(rig, number)
        return made

    def write(self, folder: Path) -> dict[str, Recording]:
        """CSV files, base.yaml, and oracle.yaml with the true structure and a start near the truth."""
        folder.mkdir(parents=True, exist_ok=True)
        made = self.records()
        for name, recording in made.items():
            write_csv(folder / f"{name}.csv", recording, speed=self.draw.condition.logs_speed)
        self.write_configs(folder)
        return made

    def write_configs(self, folder: Path) -> None:
        """What the tool is told, and what an oracle would tell it."""
        fixed: dict[str, dict[str, Any]] = {}
        if KNOWN_INERTIA in self.names:
            fixed["motor.inertia.J"] = {"guess": self.draw.base.motor_inertia, "fixed": True}
        truth: dict[str, Any] = {name: {"guess": value} for name, value in self.draw.base.named().items()}
        for hidden in self.hidden:
            truth |= {name: {"guess": value} for name, value in hidden.truth().items()}
        truth = {name: value for name, value in truth.items() if name.rpartition(".")[0] in self.structure(true=True)}
        write_config(folder / "base.yaml", self.draw, self.structure(), fixed)
        write_config(folder / "oracle.yaml", self.draw, self.structure(true=True), truth | fixed)
