"""One machine: its detection limits as the tool gives them on clean records, and effects of sizes about these."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from zlib import crc32

import numpy as np

from robotid.errors import RobotidError
from study.plant.catalogue import EFFECTS
from study.plant.draw import Draw, draw
from study.trials.case import Case, Hidden
from study.trials.tool import diagnosed, fit

TRIED = (
    "motor.asymmetric_coulomb",
    "motor.asymmetric_viscous",
    "motor.quadratic_friction",
    "motor.power_friction",
    "motor.stribeck",
    "motor.position_friction",
    "motor.cogging",
    "arm.coulomb",
    "arm.gravity",
    "gear.soft_spring",
    "gear.backlash",
    "gear.hysteresis",
    "gear.transmission_error",
    "link.third_mass",
    "torque.torque_lag",
    "angle.encoder_ripple",
)
"""Effects whose size is the parameter that the limit is given in."""
SIZES = (1.0 / 3.0, 1.0, 2.0)
"""In limits."""


@dataclass(frozen=True, slots=True)
class Spec:
    """One trial. number : of the machine; times : size of the hidden effect in limits, one of SIZES."""

    number: int
    effect: str
    times: float

    @property
    def key(self) -> str:
        """A name for files."""
        return f"{self.number}-{self.effect.replace('.', '_')}-{SIZES.index(self.times)}"


@dataclass(frozen=True, slots=True)
class Result:
    """size : of the hidden effect, infinite where there is none so large, and nothing was tried; verdict : of the tool;
    causes : that it names, each with its class; error : why the trial ended early."""

    key: str
    effect: str
    times: float
    size: float
    verdict: str = ""
    causes: tuple[tuple[str, ...], ...] = ()
    error: str = ""

    @property
    def tried(self) -> bool:
        """Whether the effect may be as large as that."""
        return bool(np.isfinite(self.size))

    @property
    def found(self) -> bool:
        """Whether the effect is in the class of a cause."""
        return any(self.effect in twins for twins in self.causes)


def run(spec: Spec, folder: Path) -> Result:
    """One trial, in a folder of its own. Raises RobotidError where the machine's clean records cannot be diagnosed."""
    (machine, shapes), name = _machine(spec.number), spec.effect
    size = spec.times * _limits(spec.number).get(name, np.inf)
    result = Result(spec.key, name, spec.times, size if size < EFFECTS[name].largest else np.inf)
    return _tried(result, Case(machine, (Hidden(name, size, shapes[name]),)), folder) if result.tried else result


def _machine(number: int) -> tuple[Draw, dict[str, dict[str, float]]]:
    """A machine, and the shape of every effect in it."""
    rng = np.random.default_rng([crc32(b"limits"), number])
    machine = draw(rng)
    return machine, {name: EFFECTS[name].shape(rng) for name in TRIED}


@cache
def _limits(number: int) -> dict[str, float]:
    """Detection limits of a machine by effect, from its clean records."""
    with TemporaryDirectory() as folder:
        Case(_machine(number)[0]).write(Path(folder))
        return {one.effect: one.size for one in diagnosed(fit(Path(folder) / "base.yaml")).limits}


def _tried(result: Result, case: Case, folder: Path) -> Result:
    try:
        case.write(folder)
        found = diagnosed(fit(folder / "base.yaml"))
    except RobotidError as error:
        return replace(result, error=f"{type(error).__name__}: {error}")
    return replace(result, verdict=found.verdict, causes=tuple(tuple(cause.twins) for cause in found.causes))
