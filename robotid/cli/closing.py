"""The last lines of a command: what came of it in a sentence, and the command to type next."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator, Sequence
from shutil import get_terminal_size
from textwrap import fill

from robotid.cli.views import view
from robotid.stages.pipeline import STAGES, Outcome, Run, State, status


def closing(run: Run, stage: str | None, done: Sequence[Outcome]) -> tuple[str, ...]:
    """Sentences on what was reached, and `next: ` with a command. stage : None for all of them."""
    return (*map(_folded, _reached(done if stage is None else done[-1:])), f"next: {next_command(run, stage)}")


def _folded(sentence: str) -> str:
    """A sentence as a terminal shows it best; a command is left alone, to be copied."""
    if not sys.stderr.isatty():
        return sentence
    return fill(sentence, get_terminal_size().columns, break_long_words=False, break_on_hyphens=False)


def _reached(done: Sequence[Outcome]) -> Iterator[str]:
    for outcome in done:
        sentence = getattr(view(outcome.stage), "sentence", None)
        if sentence is not None and outcome.content is not None:
            yield sentence(outcome.content)


def next_command(run: Run, stage: str | None = None) -> str:
    """After one stage the first that is not fresh, else all of them; of a finished run, a way to look at it."""
    due = next((s.stage for s in status(run) if s.state is not State.FRESH), None)
    if due is not None:
        return run.command(due if stage else "run")
    return shlex.join(["robotid", "show", str(run.file(list(STAGES.values())[-1]))])
