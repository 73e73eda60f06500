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


HERE = "support.fake_stages"


def _row(name: str, output: str, **what: Any) -> Stage:
    return Stage(
        name=name,
        summary=f"The {name} of three.",
        heading=name,
        output=output,
        tables="robotid.report.tables.generic",
        function=f"{HERE}:{name}",
        content=f"{HERE}:Sum",
        finding="",
        **what,
    )


STAGES = {
    "first": _row("first", "one.h5", sections=("fit",)),
    "second": _row(
        "second", "two.h5", inputs=("first",), sections=("init_rigid",), reads_files=True, after_run="always"
    ),
    "third": _row("third", "three.h5", inputs=("first", "second"), sections=("validate",), logs=True),
}
