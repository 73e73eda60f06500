"""Many trials: side by side, one file a finished trial, begun again where it was left."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

from support.paths import ROOT
from study.trials.plan import Spec
from study.trials.trial import Result, run

T = TypeVar("T")
PARTS = ("model", "terms", "channels", "signals", "simulation", "estimate", "diagnosis", "extension", "stages")
TRIAL = ("trial.py", "case.py", "sizing.py", "tool.py", "shape.py", "plan.py")


@dataclass(frozen=True, slots=True)
class Progress:
    """One more trial is done."""

    result: Result
    done: int
    of: int
    seconds_left: float


def study(specs: Sequence[Spec], folder: Path, jobs: int, patience: int, say: Callable[[Progress], None]) -> None:
    """Run the trials that are not in the folder yet. patience [s] : for each; say : told of every one."""
    folder.mkdir(parents=True, exist_ok=True)
    present = {result.key for result in finished(folder)}
    left = [spec for spec in specs if spec.key not in present]
    begin = time.perf_counter()
    with ProcessPoolExecutor(jobs) as pool:
        futures = [pool.submit(_one, spec, folder, patience) for spec in left]
        for done, future in enumerate(as_completed(futures), 1):
            spent = time.perf_counter() - begin
            say(Progress(future.result(), done, len(left), spent / done * (len(left) - done)))


def finished(folder: Path) -> Iterator[Result]:
    """Results of this very code; those of another are left alone."""
    now = digest()
    for file in sorted(folder.glob("*.json")):
        told: dict[str, Any] = json.loads(file.read_text())
        if told.pop("code") == now:
            causes = tuple((effect, tuple(twins)) for effect, twins in told["causes"])
            yield Result(**told | {"hidden": tuple(told["hidden"]), "causes": causes})


def digest() -> str:
    """Of everything that a trial depends on: the plant, the trial, and the tool but for what it shows to people."""
    here = ROOT / "tests" / "study"
    tool = [file for part in PARTS for file in (ROOT / "robotid" / part).rglob("*.py")]
    sources = sorted([*(here / "plant").glob("*.py"), *(here / "trials" / name for name in TRIAL), *tool])
    return hashlib.sha256(b"".join(file.read_bytes() for file in sources)).hexdigest()[:16]


def _one(spec: Spec, folder: Path, patience: int) -> Result:
    code = digest()  # before the trial: an edit meanwhile must not pass for what was tried
    signal.signal(signal.SIGALRM, _too_long)
    signal.alarm(patience)
    try:
        result = in_scratch(lambda scratch: run(spec, scratch))
    except Exception:  # a bug is a result as well, and must not end the study
        last = traceback.format_exc().splitlines()
        result = Result(spec.key, spec.kind, spec.names, 0.0, error=" | ".join([last[-1], *last[-3:-1]]))
    finally:
        signal.alarm(0)
    text = json.dumps({"code": code, **asdict(result)})
    unfinished = folder / f"{spec.key}.part"
    unfinished.write_text(text)
    unfinished.replace(folder / f"{spec.key}.json")
    return result


def in_scratch(trial: Callable[[Path], T]) -> T:
    """A trial in a folder of its own, the simulator's cache included, that is gone afterwards."""
    scratch = Path(tempfile.mkdtemp(prefix="trial-"))
    os.environ["ROBOTID_CACHE"] = str(scratch / "cache")
    try:
        return trial(scratch)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _too_long(*_: object) -> None:
    raise TimeoutError("took too long")
