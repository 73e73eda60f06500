"""A fresh install on the lowest and the newest versions of what robotid needs, on every Python of this machine.

python -m compatibility [--python NAME] [--only lowest|newest | --corners] [--folder FOLDER]   (tests/ on the path)

One environment for each Python and each end of the versions holds the wheel of this checkout and, of its dependencies,
either exactly the lower bounds in pyproject.toml or whatever is newest. In each, the command line answers and two
configurations are identified from their records to the report. Environments are kept in FOLDER and used again while
pyproject.toml and the interpreter stay as they are; the newest ones are made anew after a week.
"""

from __future__ import annotations

import argparse
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path

from compatibility.environment import PreparationError, Side, UnsupportedError, build_wheel, prepare
from compatibility.interpreters import Interpreter, find_interpreters
from compatibility.outcome import Outcome, State, table
from compatibility.trial import TrialError, try_out

ROOT = Path(__file__).resolve().parents[2]


def main() -> int:
    parser = argparse.ArgumentParser(prog="compatibility", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--python", action="append", metavar="NAME", help="this interpreter only (repeatable)")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--only", type=Side, choices=list(Side), help="one end of the versions only")
    which.add_argument(
        "--corners", action="store_true", help="the oldest Python with the lowest versions, the newest with the newest"
    )
    parser.add_argument("--folder", type=Path, default=ROOT / ".compatibility", help="where environments are kept")
    chosen = parser.parse_args()
    found = find_interpreters(chosen.python)
    if not found:
        print("no Python of 3.11 or newer was found", file=sys.stderr)
        return 1
    print(f"Python: {', '.join(f'{one.version} ({one.path})' for one in found)}", flush=True)
    folder = chosen.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    wheel = build_wheel(ROOT, found[0], folder)
    sides = [chosen.only] if chosen.only else list(Side)
    pairs = [(found[0], Side.LOWEST), (found[-1], Side.NEWEST)] if chosen.corners else list(product(found, sides))
    cases = [(one, side, wheel, folder) for one, side in pairs]
    with ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        outcomes = list(pool.map(lambda case: outcome(*case), cases))
    print(table(outcomes))
    return int(any(one.state is State.FAILED for one in outcomes) or all(o.state is State.SKIPPED for o in outcomes))


def outcome(interpreter: Interpreter, side: Side, wheel: Path, folder: Path) -> Outcome:
    """What one environment came to; a failure is an outcome, too."""
    result = Outcome(interpreter.version, side)
    try:
        environment = prepare(ROOT, interpreter, side, wheel, folder)
        result = Outcome(interpreter.version, side, versions=environment.versions, reused=environment.reused)
        seconds = try_out(environment, ROOT / "configs")
    except UnsupportedError as reason:
        return result.ended(State.SKIPPED, str(reason))
    except (PreparationError, TrialError) as reason:
        return result.ended(State.FAILED, str(reason))
    return result.ended(State.PASSED, seconds=seconds)


if __name__ == "__main__":
    sys.exit(main())
