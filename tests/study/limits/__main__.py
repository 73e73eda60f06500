"""Detection limits tried from the command line: how many effects of a third, one and two limits are found; begun again
where it was left."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from support.paths import ROOT

from study.limits.trial import SIZES, TRIED, Result, Spec, run
from study.trials.resumed import resumed


def main() -> None:
    """Try every effect on a few machines, and print the table."""
    parser = argparse.ArgumentParser(prog="study.limits", description=__doc__)
    parser.add_argument("--machines", type=int, default=4)
    parser.add_argument("--first", type=int, default=0, help="number of the first machine")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--folder", type=Path, default=ROOT / "trials" / "limits", help="of the results")
    asked = parser.parse_args()
    machines = range(asked.first, asked.first + asked.machines)
    specs = [Spec(number, effect, times) for number in machines for effect in TRIED for times in SIZES]
    print(table([_read(known) for known in resumed(specs, asked.folder, asked.jobs, run, _line)]))


def _line(r: Result) -> str:
    return " ".join(twins[0] for twins in r.causes) or r.error or r.verdict or "no effect is so large"


def _read(known: dict[str, Any]) -> Result:
    return Result(**known | {"causes": tuple(tuple(twins) for twins in known["causes"])})


def table(results: list[Result]) -> str:
    """Which share of the effects of each size was found, effect by effect and in all, in Markdown."""
    names = {1.0 / 3.0: "a third", 1.0: "the limit", 2.0: "twice"}
    lines = [f"| effect | {' | '.join(names[times] for times in SIZES)} |", "|---" * (len(SIZES) + 1) + "|"]
    for effect in TRIED:
        lines.append(_row(f"`{effect}`", [r for r in results if r.effect == effect]))
    return "\n".join([*lines, _row("all", results)])


def _row(name: str, results: list[Result]) -> str:
    cells = []
    for times in SIZES:
        own = [r for r in results if r.times == times and r.tried]
        cells.append(f"{sum(r.found for r in own)} of {len(own)}" if own else "-")
    return f"| {name} | {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
