"""`make chaos`: kills and damaged files until both counts or ten minutes are reached, and a line of what held."""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
import time
import warnings
from pathlib import Path

from chaos.kills import completion, duration, kill, moment
from chaos.mutations import complaint, mutated, subjects

KILLS, MUTATIONS, SECONDS = 200, 10_000, 600.0
SHARE = 0.6  # of the time that the kills may take
COMPLETE_EVERY = 20  # kills, after which the run directory is completed and begun anew


def main() -> int:
    """Exit code 1 where anything did not hold."""
    parser = argparse.ArgumentParser(prog="python -m chaos", description=__doc__)
    parser.add_argument("--seed", type=int, default=16)
    parser.add_argument("--kills", type=int, default=KILLS)
    parser.add_argument("--mutations", type=int, default=MUTATIONS)
    parser.add_argument("--seconds", type=float, default=SECONDS)
    chosen = parser.parse_args()
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        folder, rng = Path(name), random.Random(chosen.seed)
        whole = duration(folder / "run")
        print(f"seed {chosen.seed}, a whole run takes {whole:.1f} s", flush=True)
        kills = _kills(folder / "killed", whole, chosen.kills, rng, begin + SHARE * chosen.seconds)
        damaged = _mutations(folder, chosen.mutations, rng, begin + chosen.seconds)
    results = [*kills, *damaged]
    failed = [one for one in results if one]
    print(f"{len(kills)} kills, {len(damaged)} damaged files in {time.monotonic() - begin:.0f} s")
    print(f"{len(results) - len(failed)} passed, {len(failed)} failed")
    return int(bool(failed))


def _kills(folder: Path, whole: float, count: int, rng: random.Random, end: float) -> list[str]:
    """What did not hold, by kill; a run directory that is completed counts as one more."""
    found: list[str] = []
    for k in range(count):
        if time.monotonic() > end:
            break
        number, after = moment(rng, whole)
        made = kill(folder, number, after)
        found.append(_shown(f"kill {k}, {number.name} after {after:.3f} s", "; ".join(made.wrong)))
        if k % COMPLETE_EVERY == COMPLETE_EVERY - 1:
            found.append(_shown(f"completion after kill {k}", "; ".join(completion(folder))))
            shutil.rmtree(folder)
    return found


def _mutations(folder: Path, count: int, rng: random.Random, end: float) -> list[str]:
    """What did not hold, by damaged file."""
    found: list[str] = []
    made = subjects(folder, folder / "run")
    whole = {subject.file: subject.file.read_bytes() for subject in made}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for k in range(count):
            if time.monotonic() > end:
                break
            subject = made[k % len(made)]
            wrong = complaint(subject, mutated(whole[subject.file], rng, binary=subject.binary))
            found.append(_shown(f"damage {k} of {subject.file.name}", wrong))
            shutil.rmtree(folder / f"run-{subject.file.suffix[1:]}", ignore_errors=True)
    return found


def _shown(what: str, wrong: str) -> str:
    if wrong:
        print(f"{what}: {wrong}", flush=True)
    return wrong


if __name__ == "__main__":
    sys.exit(main())
