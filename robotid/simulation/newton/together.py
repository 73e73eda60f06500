"""Windows of several problems at once: reversals cost the same whether one record reverses or all do.

Each computation goes its own course, from window to window, as it would alone; only the linearisations that all of them
ask for next are made in one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TypeGuard

import numpy as np

from robotid.interrupt import check
from robotid.model.array import Array
from robotid.simulation.courses import driven
from robotid.simulation.friction.crossing import linearise_steps
from robotid.simulation.friction.step import Steps, joined
from robotid.simulation.newton.problem import Problem, WindowProblem
from robotid.simulation.newton.solver import Course, T, Window, newton_step

AT_ONCE = 32_000  # intervals: more would need more memory, and cost no less each


@np.errstate(all="ignore")  # an iterate may overflow before its window is shortened
def followed_together(courses: Sequence[Course[T]]) -> list[T]:
    """The ends of courses through problems of one joint with the same parameters."""
    return driven(courses, _changes)


def _changes(asked: Mapping[int, Window]) -> dict[int, Array]:
    """What moves each window, by number."""
    changes: dict[int, Array] = {}
    for group in _groups(asked):
        check()
        steps = _linearised([asked[k] for k in group])
        changes |= {k: newton_step(one) for k, one in zip(group, steps, strict=True)}
    return changes


def _groups(asked: Mapping[int, Window]) -> Iterator[list[int]]:
    """Numbers of windows that are linearised at once."""
    group, size = list[int](), 0
    for k, window in asked.items():
        own = window.last - window.first
        if group and size + own > AT_ONCE:
            yield group
            group, size = [], 0
        group.append(k)
        size += own
    if group:
        yield group


def _linearised(windows: Sequence[Window]) -> list[Steps]:
    """The steps of all windows."""
    if len(windows) == 1:
        (one,) = windows
        return [one.problem.linearise(one.first, one.last, one.x)]
    problems = [window.problem for window in windows]
    parts = [one.inputs(slice(w.first, w.last)) for one, w in zip(problems, windows, strict=True) if _is_plain(one)]
    x0, x1 = (np.concatenate([w.x[:, at] for w in windows], axis=1) for at in (slice(-1), slice(1, None)))
    steps, edges = linearise_steps(joined(parts), x0, x1), np.cumsum([0, *(len(part.u) for part in parts)]).tolist()
    own = (steps.part(slice(a, b)) for a, b in pairwise(edges))
    return [one.moving(part) for one, part in zip(problems, own, strict=True) if _is_plain(one)]


def _is_plain(problem: WindowProblem) -> TypeGuard[Problem]:
    """Whether a problem is of a joint's own steps."""
    return isinstance(problem, Problem)
