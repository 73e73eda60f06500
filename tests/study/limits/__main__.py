"""Detection limits tried from the command line: how many effects of a third, one and two limits are found."""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

from study.limits.trial import SIZES, TRIED, Result, run
from study.trials.study import in_scratch


def main() -> None:
    """Try every effect on a few machines, and print the table."""
    parser = argparse.ArgumentParser(prog="study.limits", description=__doc__)
    parser.add_argument("--machines", type=int, default=4)
    parser.add_argument("--first", type=int, default=0, help="number of the first machine")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--json", type=Path, help="file for all results")
    asked = parser.parse_args()
    machines = range(asked.first, asked.first + asked.machines)
    results = list[Result]()
    with ProcessPoolExecutor(asked.jobs) as pool:
        for of_one in pool.map(_one, *zip(*((k, effect) for k in machines for effect in TRIED), strict=True)):
            results += of_one
            print("\n".join(f"{len(results)} {_line(r)}" for r in of_one), file=sys.stderr, flush=True)
            if asked.json:
                asked.json.write_text(json.dumps([asdict(r) for r in results], indent=1))
    print(table(results))


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
        own = [r for r in results if r.times == times]
        cells.append(f"{sum(r.found for r in own)} of {len(own)}" if own else "-")
    return f"| {name} | {' | '.join(cells)} |"


def _one(number: int, effect: str) -> list[Result]:
    return in_scratch(lambda folder: list(run(number, effect, folder)))


def _line(one: Result) -> str:
    causes = " ".join(twins[0] for twins in one.causes)
    return f"{one.effect} of {one.times:.2g} limits: {causes or one.error or one.verdict}"


if __name__ == "__main__":
    main()
