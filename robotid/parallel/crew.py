"""How many processes may work, and those that do."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING

from robotid.parallel.threads import one_thread

if TYPE_CHECKING:
    from robotid.parallel.pool import Pool


@dataclass(slots=True, eq=False)
class Crew:
    """How many processes there may be, the seconds that tasks have taken in this one, and the pool once it is
    started. broken : processes cannot be started, or one has died, so that all work is done here."""

    jobs: int
    spent: float = 0.0
    started: Pool | None = None
    broken: bool = False

    def dismiss(self) -> None:
        """End the processes."""
        if self.started is not None:
            self.started.close()


crew_here: ContextVar[Crew | None] = ContextVar("robotid.parallel", default=None)
"""None where nothing is `working`: a task is far below those who know how many processes are wanted."""


@contextmanager
def working(jobs: int | None = None) -> Iterator[None]:
    """Within this block `each` and `ahead` use so many processes, None: as many as there are cores. Without effect
    inside another."""
    if crew_here.get() is not None:
        yield
        return
    crew = Crew(_cores() if jobs is None else jobs)
    token = crew_here.set(crew)
    try:
        yield
    finally:
        crew_here.reset(token)
        crew.dismiss()


@contextmanager
def computing(jobs: int | None = 1) -> Iterator[None]:
    """Use `jobs` processes (None: as many as there are cores), each with one thread of linear algebra."""
    with one_thread(), working(jobs):
        yield


def workers() -> int:
    """How many processes there may be here."""
    crew = crew_here.get()
    return 1 if crew is None else crew.jobs


def _cores() -> int:
    with suppress(AttributeError):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
