"""The last lines of a command: what came of it in a sentence, and the command to type next."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill

from robotid.artifacts.store import count_entries
from robotid.pipeline.execute import Outcome, status
from robotid.pipeline.freshness import StageStatus, State
from robotid.pipeline.report_page import is_current
from robotid.pipeline.run import Runs, linear_axes
from robotid.pipeline.table import DIAGNOSE, EXTEND, PRODUCTS, REPORT, STAGES, VALIDATE
from robotid.report.tables import by_axis

EXTENDED = Path("extended.yaml")


def closing(run: Runs, stage: str | None, done: Sequence[Outcome]) -> tuple[str, ...]:
    """Sentences on what was reached, and `next: ` with a command. stage : None for all of them."""
    reached = _reached(done if stage is None else done[-1:], linear_axes(run))
    return (*map(_folded, reached), f"next: {next_command(run, status(run), stage)}")


def _folded(sentence: str) -> str:
    """A sentence as a terminal shows it best; a command is left alone, to be copied."""
    if not sys.stderr.isatty():
        return sentence
    return fill(sentence, get_terminal_size().columns, break_long_words=False, break_on_hyphens=False)


def _reached(done: Sequence[Outcome], linear: Mapping[str, bool]) -> Iterator[str]:
    for outcome in done:
        view = PRODUCTS[outcome.stage].view()
        if hasattr(view, "sentence"):  # no other content is worth reading again
            yield from by_axis.sentences(view, outcome.contents, linear)


def next_command(run: Runs, found: Sequence[StageStatus], stage: str | None = None) -> str:
    """After one stage the first that is due, else all of them; then the report; then the extended model, where there
    is one; else a way to look. found : the state of every stage."""
    unread = _unread(run)
    due = next((s.stage for s in found if s.state is not State.FRESH and s.stage not in unread), None)
    if due is not None and not (due == EXTEND.name and stage is not None and _is_clean(run)):
        return run.command(due if stage else "run")
    if not is_current(run, found):
        return run.command(REPORT.name)
    if due is None and any(count_entries(run.file(EXTEND), "added", axis) for axis in run.axes):
        again = f"{run.out}-{EXTENDED.stem}"
        return shlex.join(["robotid", "run", str(run.out / EXTENDED), "--out", again])
    return shlex.join(["robotid", "show", str(run.file(VALIDATE if due is None else DIAGNOSE))])


def _unread(run: Runs) -> set[str]:
    """Stages that records which excite need, where none does."""
    axes, stages = run.axes.values(), STAGES.values()
    return {name for axis in axes for stage in stages for name in {*stage.for_virtual} - {*axis.needs(stage)}}


def _is_clean(run: Runs) -> bool:
    """Whether the diagnosis names nothing to extend by."""
    return not any(count_entries(run.file(DIAGNOSE), "causes", axis) for axis in run.axes)
