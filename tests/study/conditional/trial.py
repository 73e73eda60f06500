"""One trial under a condition: the tool gets the files alone, and what it says is set beside the truth."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from pathlib import Path

from robotid.errors import RobotidError
from study.conditional.plan import BESIDE, Spec
from study.plant.conditions import CONDITIONS
from study.plant.draw import draw
from study.plant.strangers import STRANGERS
from study.trials.case import Case, Hidden
from study.trials.tool import diagnose, fit
from study.trials.trial import alone, drawn_effect

COST = 9.0
"""Of a true effect, in noise standard deviations of the white-noise study's recording."""
TWO_SIGMA = 1.96


@dataclass(frozen=True, slots=True)
class Result:
    """What a trial came to, ready for JSON. hidden : true effects; causes : effect and its class, in order; covered :
    for each parameter of a true effect that was found, whether its value lies within two standard deviations."""

    key: str
    condition: str
    kind: str
    name: str
    hidden: tuple[str, ...] = ()
    verdict: str = ""
    causes: tuple[tuple[str, tuple[str, ...]], ...] = ()
    covered: dict[str, bool] = field(default_factory=dict)
    seconds: float = 0.0
    error: str = ""

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
        case = prepared(spec, folder)
        result = replace(result, hidden=tuple(h.name for h in case.hidden if h.name not in STRANGERS))
        case.write(folder / "records")
        diagnosis, extension = diagnose(fit(folder / "records" / "base.yaml"))
        result = replace(
            result,
            verdict=diagnosis.verdict,
            causes=tuple((c.effect, c.twins) for c in diagnosis.causes),
            covered=_covered(case, {p.name: (p.value, p.std_robust) for p in extension.fit.parameters}),
        )
    except RobotidError as error:
        result = replace(result, error=f"{type(error).__name__}: {error}")
    return replace(result, seconds=time.perf_counter() - begin)


def prepared(spec: Spec, folder: Path) -> Case:
    """The machine with what is hidden in it, under the condition."""
    rng = spec.rng()
    machine = draw(rng)
    hidden: list[Hidden] = []
    if spec.kind in ("stranger", "both"):
        stranger = STRANGERS[spec.name]
        hidden.append(Hidden(spec.name, stranger.size, stranger.shape(rng)))
    if spec.kind in ("effect", "both"):
        name = spec.name if spec.kind == "effect" else BESIDE
        hidden += alone(machine, drawn_effect(name, rng), COST, folder / "sizing").case.hidden
    return Case(machine.under(CONDITIONS[spec.condition]), tuple(hidden))


def _covered(case: Case, found: dict[str, tuple[float, float]]) -> dict[str, bool]:
    """Parameters of the hidden effects that were found: whether the truth lies in their interval."""
    truth = {name: value for h in case.hidden if h.name not in STRANGERS for name, value in h.truth().items()}
    known = {name: found[name] for name in truth if name in found}
    return {name: abs(value - truth[name]) <= TWO_SIGMA * std for name, (value, std) in known.items()}
