"""The study under conditions from the command line, begun again where it was left."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from support.paths import ROOT

from study.conditional.plan import every
from study.conditional.table import table
from study.conditional.trial import Result, run
from study.trials.resumed import resumed


def main() -> None:
    """Run what is missing, and print the table."""
    parser = argparse.ArgumentParser(prog="study.conditional", description=__doc__)
    parser.add_argument("--only", action="append", default=[], help="condition, kind or name; repeatable")
    parser.add_argument("--clean", type=int, default=30, help="draws without an effect under each condition")
    parser.add_argument("--draws", type=int, default=2, help="of every effect and stranger")
    parser.add_argument("--first", type=int, default=0, help="number of the first draw: others are other machines")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--folder", type=Path, default=ROOT / "trials" / "conditional", help="of the results")
    asked = parser.parse_args()
    planned = every(asked.clean, asked.draws, asked.first)
    specs = [s for s in planned if not asked.only or {s.condition, s.kind, s.name} & set(asked.only)]
    print(table([_read(known) for known in resumed(specs, asked.folder, asked.jobs, run, _line)]))


def _line(r: Result) -> str:
    return f"{', '.join(effect for effect, _ in r.causes) or r.error[:100] or r.verdict} ({r.seconds:.0f} s)"


def _read(known: dict[str, Any]) -> Result:
    causes = tuple((effect, tuple(twins)) for effect, twins in known["causes"])
    return Result(**known | {key: tuple(known[key]) for key in ("hidden", "below")} | {"causes": causes})


if __name__ == "__main__":
    main()
