"""The study from the command line: `python -m study --help`, with tests/ on the path. `make trials` runs all of it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from study.trials.judgement import judge
from study.trials.plan import DRAWS, Spec, every
from study.trials.study import ROOT, Progress, finished, study
from study.trials.table import PAGE, table, write


def main() -> None:
    """Run what is missing, and print the table."""
    asked = _arguments()
    specs = [spec for spec in every(1 if asked.quick else asked.draws, asked.first) if _wanted(spec, asked)]
    if not asked.summary:
        study(specs, asked.folder, asked.jobs, asked.patience, _say)
    results, keys = list(finished(asked.folder)), {spec.key for spec in specs}
    print(table([result for result in results if result.key in keys]))
    if asked.manual:
        write(ROOT / PAGE, table(results))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="study", description=__doc__)
    parser.add_argument("--only", action="append", default=[], help="effect, or kind of trial; repeatable")
    parser.add_argument("--draws", type=int, default=DRAWS, help="of every effect at each size")
    parser.add_argument("--first", type=int, default=0, help="number of the first draw: others are other machines")
    parser.add_argument(
        "--quick", action="store_true", help="one large draw of every effect, and the rest in proportion"
    )
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--patience", type=int, default=900, help="seconds that a trial may take")
    parser.add_argument("--folder", type=Path, default=ROOT / "trials", help="of the results")
    parser.add_argument("--summary", action="store_true", help="only the table of what is there")
    parser.add_argument("--manual", action="store_true", help="write the table to the manual")
    return parser.parse_args()


def _wanted(spec: Spec, asked: argparse.Namespace) -> bool:
    if asked.quick and spec.size == "small" and spec.kind != "pair":
        return False
    return not asked.only or bool({spec.kind, *spec.names} & set(asked.only))


def _say(progress: Progress) -> None:
    result, judged = progress.result, judge(progress.result)
    causes = ", ".join(effect for effect, _ in result.causes) or result.error[:80] or result.verdict
    mark = "right" if judged.right else "class" if judged.in_class else "WRONG"
    left = f"{progress.seconds_left / 60:.0f} min left"
    print(f"{progress.done}/{progress.of} {left}  {mark}  {result.key}: {causes}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
