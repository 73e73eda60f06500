"""One trial under a condition: the tool gets the files alone, and what it says is set beside the truth."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from robotid.diagnosis.results import Diagnosis
from robotid.errors import RobotidError
from robotid.extension import Extension
from study.conditional.plan import BESIDE, PLAIN, Spec
from study.plant.conditions import CONDITIONS
from study.plant.draw import Draw, draw
from study.plant.strangers import STRANGERS
from study.trials.case import Case, Hidden
from study.trials.tool import diagnose, fit
from study.trials.trial import alone, drawn_effect

COST = 9.0
"""That a true effect is sized for, in noise standard deviations of the white-noise study's recording."""
TWO_SIGMA = 1.96


@dataclass(frozen=True, slots=True)
class Result:
    """What a trial came to, ready for JSON. hidden : true effects; causes : effect and its class, in order; covered :
    for each parameter of a true effect that was found, whether its value lies within two standard deviations; cost : of
    leaving the true effect out on the white-noise study's recording, in its noise standard deviations; below : of the
    true effects that are no cause, those smaller than their own detection limit."""

    key: str
    condition: str
    kind: str
    name: str
    hidden: tuple[str, ...] = ()
    verdict: str = ""
    causes: tuple[tuple[str, tuple[str, ...]], ...] = ()
    covered: dict[str, bool] = field(default_factory=dict)
    cost: float = COST
    below: tuple[str, ...] = ()
    seconds: float = 0.0
    error: str = ""

    @property
    def visible(self) -> bool:
        """Whether these records show the true effect: it costs what it was sized for, or half of that, and is not below
        its detection limit."""
        return self.cost > COST / 2.0 and not self.below

    @property
    def first(self) -> bool:
        """The true effect is in the first cause's class."""
        return bool(self.hidden) and any(set(self.hidden) & set(twins) for _, twins in self.causes[:1])

    @property
    def false(self) -> int:
        """Causes in whose class no true effect is."""
        return sum(not set(self.hidden) & set(twins) for _, twins in self.causes)


def run(spec: Spec, folder: Path) -> Result:
    """The whole trial in a folder of its own. An error of the tool is part of the result."""
    begin = time.perf_counter()
    result = Result(spec.key, spec.condition, spec.kind, spec.name)
    try:
        case, cost = prepared(spec)
        result = replace(result, hidden=tuple(h.name for h in case.hidden if h.name not in STRANGERS), cost=cost)
        case.write(folder / "records")
        diagnosis, extension = diagnose(fit(folder / "records" / "base.yaml"))
        result = replace(
            result,
            verdict=diagnosis.verdict,
            causes=tuple((c.effect, c.twins) for c in diagnosis.causes),
            below=tuple(_below(case, diagnosis)),
            covered=_covered(case, _found(diagnosis, extension)),
        )
    except RobotidError as error:
        result = replace(result, error=f"{type(error).__name__}: {error}")
    return replace(result, seconds=time.perf_counter() - begin)


def prepared(spec: Spec) -> tuple[Case, float]:
    """The machine with what is hidden in it, under the condition, and the cost of its true effect."""
    machine, hidden, cost = _hidden(replace(spec, condition=PLAIN))
    return Case(machine.under(CONDITIONS[spec.condition]), hidden), cost


@cache
def _hidden(spec: Spec) -> tuple[Draw, tuple[Hidden, ...], float]:
    """A machine, what is hidden in it, and the cost of its true effect: the same under all conditions."""
    rng = spec.rng()
    machine = draw(rng)
    hidden, cost = list[Hidden](), COST
    if spec.kind in ("stranger", "both"):
        stranger = STRANGERS[spec.name]
        hidden.append(Hidden(spec.name, stranger.size, stranger.shape(rng)))
    if spec.kind in ("effect", "both"):
        name = spec.name if spec.kind == "effect" else BESIDE
        with TemporaryDirectory() as folder:
            one = alone(machine, drawn_effect(name, rng), COST, Path(folder))
        hidden, cost = [*hidden, *one.case.hidden], one.cost
    return machine, tuple(hidden), cost


def _below(case: Case, diagnosis: Diagnosis) -> Iterator[str]:
    """True effects that are smaller than the limit that the diagnosis gives for them; causes have none."""
    limits = {one.effect: one.size for one in diagnosis.limits}
    return (h.name for h in case.hidden if h.size < limits.get(h.name, 0.0))


def _found(diagnosis: Diagnosis, extension: Extension) -> dict[str, tuple[float, float]]:
    """Values and standard deviations of the extended model; of what that holds, those of the diagnosis."""
    held = [p for cause in diagnosis.causes for p in cause.parameters] if diagnosis.beside_shape else []
    return {p.name: (p.value, p.std_robust) for p in (*extension.fit.parameters, *held)}


def _covered(case: Case, found: dict[str, tuple[float, float]]) -> dict[str, bool]:
    """Parameters of the hidden effects that were found: whether the truth lies in their interval."""
    truth = {name: value for h in case.hidden if h.name not in STRANGERS for name, value in h.truth().items()}
    known = {name: found[name] for name in truth if name in found}
    return {name: abs(value - truth[name]) <= TWO_SIGMA * std for name, (value, std) in known.items()}
