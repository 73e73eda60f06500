"""Clean draws under every condition, and how often a p-value of what is not there falls below a level; begun again
where it was left."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from support.paths import ROOT

from study.calibration.trial import Result, run
from study.conditional.plan import Spec
from study.plant.conditions import CONDITIONS
from study.trials.resumed import resumed

LEVELS = (0.5, 0.1, 0.01, 0.001)


def main() -> None:
    """Try clean machines, and print the table."""
    parser = argparse.ArgumentParser(prog="study.calibration", description=__doc__)
    parser.add_argument("--draws", type=int, default=29, help="under each condition")
    parser.add_argument("--first", type=int, default=0, help="number of the first draw")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--folder", type=Path, default=ROOT / "trials" / "calibration", help="of the results")
    asked = parser.parse_args()
    specs = [Spec(name, "clean", "none", asked.first + k) for k in range(asked.draws) for name in CONDITIONS]
    print(table([Result(**known) for known in resumed(specs, asked.folder, asked.jobs, run, _line)]))


def _line(r: Result) -> str:
    return r.error or f"{r.best:.2g}"


def table(results: Sequence[Result]) -> str:
    """Of one effect and of the best of all, the share of p-values below each level, condition by condition."""
    levels = " | ".join(f"p < {level:g}" for level in LEVELS)
    lines = [f"| condition | draws | {levels} | best of all < {LEVELS[-1]:g} |", "|---" * (len(LEVELS) + 3) + "|"]
    names = dict.fromkeys(r.condition for r in results)
    lines += [_row(name, [r for r in results if r.condition == name]) for name in names]
    return "\n".join([*lines, _row("all", results)])


def _row(name: str, results: Sequence[Result]) -> str:
    own = np.array(list(_values(results)))
    shares = " | ".join(f"{100 * np.mean(own < level):.2g} %" for level in LEVELS) if own.size else "-"
    below = sum(r.best < LEVELS[-1] for r in results if not r.error)
    return f"| {name} | {len(results)} | {shares} | {below} |"


def _values(results: Sequence[Result]) -> Iterator[float]:
    return (p for r in results for p in r.alone.values())


if __name__ == "__main__":
    main()
