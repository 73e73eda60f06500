"""The trials on two axes from the command line, begun again where they were left."""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path

from support.paths import ROOT

from study.axes.plan import DRAWS, Spec, every
from study.axes.table import table
from study.axes.trial import Result, run
from study.trials.study import in_scratch


def main() -> None:
    """Run what is missing, and print the table."""
    parser = argparse.ArgumentParser(prog="study.axes", description=__doc__)
    parser.add_argument("--only", action="append", default=[], help="kind or key of a trial; repeatable")
    parser.add_argument("--draws", type=int, default=DRAWS, help="of every kind")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--folder", type=Path, default=ROOT / "trials" / "axes", help="of the results")
    asked = parser.parse_args()
    specs = [s for s in every(asked.draws) if not asked.only or {s.kind, s.key} & set(asked.only)]
    asked.folder.mkdir(parents=True, exist_ok=True)
    left = [spec for spec in specs if not _file(asked.folder, spec).exists()]
    with ProcessPoolExecutor(asked.jobs) as pool:
        futures = [pool.submit(_one, spec, asked.folder) for spec in left]
        for done, future in enumerate(as_completed(futures), 1):
            r = future.result()
            named = ", ".join(effect for effect, _ in r.causes) or r.error[:100] or r.verdict
            print(f"{done}/{len(left)} {r.key}: {named} ({sum(r.seconds.values()):.0f} s)", file=sys.stderr, flush=True)
    print(table([_read(_file(asked.folder, spec)) for spec in specs if _file(asked.folder, spec).exists()]))


def _file(folder: Path, spec: Spec) -> Path:
    return folder / f"{spec.key}.json"


def _one(spec: Spec, folder: Path) -> Result:
    result = in_scratch(lambda scratch: run(spec, scratch))
    _file(folder, spec).write_text(json.dumps(asdict(result)))
    return result


def _read(file: Path) -> Result:
    known = json.loads(file.read_text())
    return Result(**known | {"causes": tuple((effect, tuple(twins)) for effect, twins in known["causes"])})


if __name__ == "__main__":
    main()
