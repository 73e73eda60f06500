"""Three stages that do next to nothing, count their calls, and fail when told to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from robotid.config.schema import Config
from robotid.pipeline.stage import Stage
from robotid.progress import Progress

CALLS: Counter[str] = Counter()
FAILURES: dict[str, BaseException] = {}


@dataclass(frozen=True, slots=True)
class Sum:
    value: float
    interrupted: bool = False
    failed: tuple[str, ...] = ()


def first(settings: Config) -> Sum:
    _called("first")
    return Sum(float(settings.fit.max_iterations > 50))


def second(settings: Config, before: Sum, files: Mapping[str, Any]) -> Sum:
    _called("second")
    return Sum(before.value + len(files) + sum(len(table.columns) for table in files.values()))


def third(settings: Config, one: Sum, two: Sum, log: Callable[..., None] | None = None) -> Sum:
    _called("third")
    if log is not None:
        log(Progress("third", 1, 2))
    worse = ("the fit is 1 %, below 2 %",) if settings.validation.perturbation == 13.0 else ()
    return Sum(one.value + two.value, settings.validation.perturbation == 12.0, worse)


def _called(name: str) -> None:
    CALLS[name] += 1
    if name in FAILURES:
        raise FAILURES[name]


HERE, SUM = "support.fake_stages", "support.fake_stages:Sum"
STAGES = {
    "first": Stage("first", "one.h5", f"{HERE}:first", SUM, sections=("fit",)),
    "second": Stage("second", "two.h5", f"{HERE}:second", SUM, ("first",), ("init_rigid",), files=True),
    "third": Stage("third", "three.h5", f"{HERE}:third", SUM, ("first", "second"), ("validate",), logs=True),
}
