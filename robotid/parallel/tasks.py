"""Tasks of one call, shared out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from robotid.parallel.crew import crew_here
from robotid.parallel.pool import Work, pool_of
from robotid.parallel.results import Event, Item, OneByOne, Result
from robotid.parallel.sending import as_sent

SECONDS_PER_SAMPLE = 2e-5  # of a fit, about: what is known of a task before it has run


def each(
    task: Callable[..., Result],
    shared: Any,
    items: Sequence[Item],
    *,
    samples: int,
    log: Event | None = None,
) -> list[Result]:
    """The results of task(shared, item) of all items. Arguments and errors as of `ahead`."""
    with ahead(task, shared, items, samples=samples, log=log) as results:
        return list(results)


@contextmanager
def ahead(
    task: Callable[..., Result],
    shared: Any,
    items: Sequence[Item],
    *,
    samples: int,
    log: Event | None = None,
    hands_on_interrupts: bool = False,
    meanwhile: bool = False,
) -> Iterator[Sequence[Result]]:
    """The results of task(shared, item), each there when it is asked for: other processes work ahead, this one works
    when asked. What is not asked for within the block is dropped.

    samples : over which a task runs, to tell whether it is worth a process. log : what tasks report; they are called
    with it as log=, and reports arrive in the order in which results are asked for. hands_on_interrupts : an interrupt
    goes to the tasks, which end early; else it ends the wait. meanwhile : this process does something else before it
    asks, so that even one item is worth another process.

    Raises, when a result is asked for, what its task raised.
    """
    crew, seconds = crew_here.get(), samples * len(items) * SECONDS_PER_SAMPLE
    alone = len(items) < (1 if meanwhile else 2)
    pool = None if crew is None or alone else pool_of(crew, seconds)
    if pool is not None:
        with pool.call(Work(task, items, log, hands_on_interrupts), shared) as results:
            if results is not None:
                yield results
                return
    yield OneByOne(task, as_sent(shared), items, log, crew)


def expect(samples: int) -> None:
    """Fits over so many samples are about to come, one after the other and several at a time: processes that are worth
    their start begin it now."""
    crew = crew_here.get()
    if crew is not None:
        pool_of(crew, samples * SECONDS_PER_SAMPLE)
