"""Results of tasks, each there when it is asked for, and those that this process works out itself."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, Generic, TypeVar, overload

from robotid.parallel.crew import Crew
from robotid.parallel.sending import as_sent

Item = TypeVar("Item")
Result = TypeVar("Result")

Event = Callable[[Any], None]
"""Is called with what a task reports while it works."""


class Lazily(Sequence[Result]):
    """Results by number."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._known: dict[int, Result] = {}

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Result]:
        """One after the other: an IndexError of a task is no end of them."""
        return (self[k] for k in range(self._count))

    @overload
    def __getitem__(self, k: int) -> Result: ...
    @overload
    def __getitem__(self, k: slice) -> Sequence[Result]: ...
    def __getitem__(self, k: int | slice) -> Result | Sequence[Result]:
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(self._count))]
        if not 0 <= k < self._count:
            raise IndexError(k)
        if k not in self._known:
            self._known[k] = self._result(k)
        found: Result = self._known[k]
        return found

    def _result(self, k: int) -> Result:
        raise NotImplementedError


class OneByOne(Lazily[Result], Generic[Item, Result]):
    """Results of this process."""

    def __init__(
        self, task: Callable[..., Result], shared: Any, items: Sequence[Item], log: Event | None, crew: Crew | None
    ) -> None:
        super().__init__(len(items))
        self._task = task if log is None else partial(task, log=log)
        self._shared, self._items, self._crew = shared, items, crew

    def _result(self, k: int) -> Result:
        begin = time.perf_counter()
        found: Result = as_sent(self._task(self._shared, as_sent(self._items[k])))
        if self._crew is not None:
            self._crew.spent += time.perf_counter() - begin
        return found
