"""Whether what the tool said of a trial is right."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from study.trials.trial import Result

WORTH = 3.0  # noise standard deviations that leaving the effect out must cost for the goals to apply
SHAPE = 0.95  # correlation of the shape of an unknown effect
SHARE = 0.95  # of the oracle's gain


@dataclass(frozen=True, slots=True)
class Judgement:
    """right : the first cause is what is hidden (for a pair: every hidden effect is named, for a clean record: none,
    for an unknown effect: the verdict); in_class : the same, counting the causes' classes. false : causes that are
    none, classes considered. missed : nothing was named though something was hidden. share : gain on held-out records
    over the oracle's, nan where there is none. shape : whether the shape of an unknown effect is right.
    """

    worth: bool
    right: bool
    in_class: bool
    false: int
    missed: bool
    share: float
    shape: bool


def judge(result: Result) -> Judgement:
    """By the kind of the trial. A trial that ended in an error of the tool has nothing right."""
    hidden, first = set(result.hidden), result.causes[:1]
    named, classes = {effect for effect, _ in result.causes}, [set(twins) for _, twins in result.causes]
    false = sum(not twins & hidden for twins in classes)
    if result.kind == "effect":
        right = any(effect in hidden for effect, _ in first)
        in_class = any(hidden & twins for twins in classes[:1])
    elif result.kind == "pair":
        right, in_class = hidden <= named, hidden <= set().union(*classes)
    else:
        right = in_class = result.verdict == {"clean": "clean", "unknown": "unknown"}[result.kind]
    return Judgement(
        worth=not result.cost < WORTH or result.kind == "clean",
        right=right,
        in_class=in_class,
        false=false,
        missed=not result.causes and result.verdict != "unknown" and result.kind != "clean",
        share=_share(result),
        shape=result.correlation >= SHAPE,
    )


def _share(result: Result) -> float:
    """Gain in RMS error on held-out records, as a share of the oracle's; none where the tool stopped."""
    base, oracle = (result.rmse.get(name, np.nan) for name in ("base", "oracle"))
    extended = result.rmse.get("extended", base)
    return (base - extended) / (base - oracle) if base > oracle else float("nan")
