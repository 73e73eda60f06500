"""The study under conditions from the command line, begun again where it was left."""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path

from support.paths import ROOT

from study.conditional.plan import Spec, every
from study.conditional.table import table
from study.conditional.trial import Result, run
from study.trials.study import in_scratch


def main() -> None:
    """Run what is missing, and print the table."""
    parser = argparse.ArgumentParser(prog="study.conditional", description=__doc__)
    parser.add_argument("--only", action="append", default=[], help="condition, kind or name; repeatable")
    parser.add_argument("--clean", type=int, default=30, help="draws without an effect under each condition")
    parser.add_argument("--draws", type=int, default=2, help="of every effect and stranger")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--folder", type=Path, default=ROOT / "trials" / "conditional", help="of the results")
    asked = parser.parse_args()
    specs = [
        s for s in every(asked.clean, asked.draws) if not asked.only or {s.condition, s.kind, s.name} & set(asked.only)
    ]
    asked.folder.mkdir(parents=True, exist_ok=True)
    left = [spec for spec in specs if not _file(asked.folder, spec).exists()]
    with ProcessPoolExecutor(asked.jobs) as pool:
        futures = [pool.submit(_one, spec, asked.folder) for spec in left]
        for done, future in enumerate(as_completed(futures), 1):
            r = future.result()
            said = ", ".join(effect for effect, _ in r.causes) or r.error[:100] or r.verdict
            print(f"{done}/{len(left)} {r.key}: {said} ({r.seconds:.0f} s)", file=sys.stderr, flush=True)
    print(table([_read(_file(asked.folder, spec)) for spec in specs if _file(asked.folder, spec).exists()]))


def _file(folder: Path, spec: Spec) -> Path:
    return folder / f"{spec.key}.json"


def _one(spec: Spec, folder: Path) -> Result:
    result = in_scratch(lambda scratch: run(spec, scratch))
    _file(folder, spec).write_text(json.dumps(asdict(result)))
    return result


def _read(file: Path) -> Result:
    known = json.loads(file.read_text())
    causes = tuple((effect, tuple(twins)) for effect, twins in known["causes"])
    return Result(**known | {key: tuple(known[key]) for key in ("hidden", "below")} | {"causes": causes})


if __name__ == "__main__":
    main()
