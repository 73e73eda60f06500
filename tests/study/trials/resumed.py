"""Trials side by side, one file a finished trial, begun again where they were left."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path
from typing import Any, Protocol, TypeVar

from study.trials.study import in_scratch


class Keyed(Protocol):
    """A trial, or what it came to."""

    @property
    def key(self) -> str: ...


S = TypeVar("S", bound=Keyed)
R = TypeVar("R", bound=Keyed)


def resumed(
    specs: Sequence[S], folder: Path, jobs: int, run: Callable[[S, Path], Any], line: Callable[[Any], str]
) -> list[dict[str, Any]]:
    """Run the trials that are not in the folder yet, in so many processes; what all of them came to, as JSON has it.

    run : makes a result, a dataclass, of a trial and a folder of its own; line : a result in words.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = {spec.key: folder / f"{spec.key}.json" for spec in specs}
    left = [spec for spec in specs if not files[spec.key].exists()]
    with ProcessPoolExecutor(jobs) as pool:
        futures = [pool.submit(_one, run, spec, files[spec.key]) for spec in left]
        for done, future in enumerate(as_completed(futures), 1):
            result = future.result()
            print(f"{done}/{len(left)} {result.key}: {line(result)}", file=sys.stderr, flush=True)
    return [json.loads(file.read_text()) for file in files.values() if file.exists()]


def _one(run: Callable[[S, Path], R], spec: S, file: Path) -> R:
    result = in_scratch(lambda scratch: run(spec, scratch))
    unfinished = file.with_suffix(".part")
    unfinished.write_text(json.dumps(asdict(result)))  # type: ignore[call-overload]
    unfinished.replace(file)
    return result
