"""Clean draws under every condition, and how often a p-value of what is not there falls below a level."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

import numpy as np

from study.calibration.trial import Result, run
from study.conditional.plan import Spec
from study.plant.conditions import CONDITIONS
from study.trials.study import in_scratch

LEVELS = (0.5, 0.1, 0.01, 0.001)


def main() -> None:
    """Try clean machines, and print the table."""
    parser = argparse.ArgumentParser(prog="study.calibration", description=__doc__)
    parser.add_argument("--draws", type=int, default=29, help="under each condition")
    parser.add_argument("--first", type=int, default=0, help="number of the first draw")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--json", type=Path, help="file for all results")
    asked = parser.parse_args()
    specs = [Spec(name, "clean", "none", asked.first + k) for k in range(asked.draws) for name in CONDITIONS]
    results = list[Result]()
    with ProcessPoolExecutor(asked.jobs) as pool:
        for result in pool.map(_one, specs):
            results.append(result)
            print(
                f"{len(results)}/{len(specs)} {result.key}: {result.best:.2g} {result.error}",
                file=sys.stderr,
                flush=True,
            )
            if asked.json:
                asked.json.write_text(json.dumps([asdict(r) for r in results]))
    print(table(results))


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


def _one(spec: Spec) -> Result:
    return in_scratch(lambda folder: run(spec, folder))


if __name__ == "__main__":
    main()
