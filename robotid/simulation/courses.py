"""Computations that ask as they go, several at a time: what all of them ask next is answered at once."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from typing import Any, TypeVar

Q = TypeVar("Q")
T = TypeVar("T")


def driven(courses: Sequence[Generator[Q, Any, T]], answer: Callable[[Mapping[int, Q]], Mapping[int, Any]]) -> list[T]:
    """The ends of all courses.

    answer : of the questions asked, by number of the course; an exception is raised in the course that asked.
    """
    found: dict[int, T] = {}
    answers: Mapping[int, Any] = dict.fromkeys(range(len(courses)))
    while answers:
        asked: dict[int, Q] = {}
        for k, given in answers.items():
            try:
                asked[k] = _go_on(courses[k], given)
            except StopIteration as end:
                found[k] = end.value
        answers = answer(asked)
    return [found[k] for k in range(len(courses))]


def _go_on(course: Generator[Q, Any, T], given: Any) -> Q:
    if isinstance(given, Exception):
        return course.throw(given)
    return next(course) if given is None else course.send(given)
