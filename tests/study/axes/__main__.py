"""The trials on two axes from the command line, begun again where they were left."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from support.paths import ROOT

from study.axes.plan import DRAWS, every
from study.axes.table import table
from study.axes.trial import Result, run
from study.trials.resumed import resumed


def main() -> None:
    """Run what is missing, and print the table."""
    parser = argparse.ArgumentParser(prog="study.axes", description=__doc__)
    parser.add_argument("--only", action="append", default=[], help="kind or key of a trial; repeatable")
    parser.add_argument("--draws", type=int, default=DRAWS, help="of every kind")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--folder", type=Path, default=ROOT / "trials" / "axes", help="of the results")
    asked = parser.parse_args()
    specs = [s for s in every(asked.draws) if not asked.only or {s.kind, s.key} & set(asked.only)]
    print(table([_read(known) for known in resumed(specs, asked.folder, asked.jobs, run, _line)]))


def _line(r: Result) -> str:
    named = ", ".join(effect for effect, _ in r.causes) or r.error[:100] or r.verdict
    return f"{named} ({sum(r.seconds.values()):.0f} s)"


def _read(known: dict[str, Any]) -> Result:
    return Result(**known | {"causes": tuple((effect, tuple(twins)) for effect, twins in known["causes"])})


if __name__ == "__main__":
    main()
