"""The iteration log of a fit: a bar below the lines on a terminal, the lines alone elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from robotid.cli.console import say

if TYPE_CHECKING:
    from robotid.estimate.least_squares import Iteration

Log = Callable[[str, "Iteration"], None]


@contextmanager
def iteration_log(models: int, *, quiet: bool) -> Iterator[Log | None]:
    """What a fit of so many models tells its iterations to; None where nobody listens."""
    if quiet:
        yield None
    elif sys.stderr.isatty():
        with _bar(models) as log:
            yield log
    else:
        yield lambda model, iteration: say(_line(model, iteration))


def _line(model: str, iteration: Iteration) -> str:
    return f"{model}  iteration {iteration.number:3d}  cost {iteration.cost:.6e}  decrease {iteration.decrease:.1e}"


@contextmanager
def _bar(models: int) -> Iterator[Log]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True, highlight=False), transient=True) as progress:
        task = progress.add_task("fit", total=models)
        begun: list[str] = []

        def log(model: str, iteration: Iteration) -> None:
            if model not in begun:
                begun.append(model)
            progress.console.print(_line(model, iteration), markup=False)
            progress.update(task, description=f"fit {model}", completed=len(begun) - 1)

        yield log
