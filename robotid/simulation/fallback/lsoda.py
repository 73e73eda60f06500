"""LSODA where Newton's method fails: slow, robust, and asked the same question again by every fit, hence cached."""

from __future__ import annotations

import hashlib
import inspect
import warnings
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from scipy.integrate import LSODA

from robotid import __version__
from robotid.errors import NumericsError
from robotid.interrupt import check
from robotid.model.array import Array
from robotid.model.companion import MOTOR_ANGLE
from robotid.model.joint import Joint
from robotid.model.term import Term
from robotid.simulation.fallback.cache import cached
from robotid.simulation.newton.problem import Problem
from robotid.simulation.newton.solver import MAX_STATE

_lsoda: Any = LSODA  # its types take every right-hand side for complex

RTOL, ATOL = 1e-8, 1e-11
MAX_STEPS = 500  # a sampling interval, ODEPACK's own default: some ten oscillations, which no record shows
SMOOTHING = 1e-4  # rad/s: LSODA needs a continuous friction law


def lsoda(problem: Problem, first: int, stop: int, start: Array) -> Array:
    """Nodes first .. stop by LSODA from the state start (nx,), (nx, stop - first + 1).

    The answer comes from the cache where the same question was asked before. Raises NumericsError on divergence, and
    for a motion that takes more than MAX_STEPS steps an interval. They are counted over all intervals together: what
    dies out within one, such as a stiff arm that comes to rest, may take as many as it needs.
    """
    if len(problem.joint.terms) != len(problem.joint.structure.terms):  # a term that has no name yet
        return _integrate(problem, first, stop, start)
    shape = (len(start), stop - first + 1)
    return cached(_key(problem, first, stop, start), shape, lambda: _integrate(problem, first, stop, start))


def smooth_rate(joint: Joint, x: Array, u: float, t: float, theta: Array) -> Array:
    """dx/dt at one state x (nx,) with sgn(v) smoothed as v / sqrt(v^2 + eps^2), (nx,)."""
    v = x[joint.speeds, None]
    s = v / np.sqrt(v**2 + SMOOTHING**2)
    return joint.evaluate(x[:, None], np.array([u]), s, np.array([t]), theta).f[:, 0]


@np.errstate(all="ignore")  # a motion that diverges is reported below
def _integrate(problem: Problem, first: int, stop: int, start: Array) -> Array:
    h, x, steps = problem.sampling_time, [start], 0
    for k in range(first, stop):
        state = x[-1]
        for begin, end, torque in _held_torques(problem, k):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # that it failed is reported below
                solver = _lsoda(
                    lambda t, y, torque=torque: smooth_rate(problem.joint, y, torque, t, problem.theta),
                    problem.begin + (k + begin) * h,
                    state,
                    problem.begin + (k + end) * h,
                    rtol=RTOL,
                    atol=ATOL,
                )
                while solver.status == "running":
                    check()
                    solver.step()
                    steps += 1
                    if steps > MAX_STEPS * (stop - first):
                        raise NumericsError(
                            f"the simulation moves much faster than it is sampled at t = {k * h:.4g} s",
                            hint="check the parameters' guesses and bounds",
                        )
            state = solver.y
            if solver.status == "failed" or not np.abs(state).max() < MAX_STATE:
                raise NumericsError(
                    f"the simulation diverges at t = {k * h:.4g} s", hint="check the parameters' guesses and bounds"
                )
        x.append(state)
    return np.stack(x, axis=1)


def _held_torques(problem: Problem, k: int) -> Iterator[tuple[float, float, float]]:
    """The parts of interval k over which the torque is constant: from and to which share of it, and the torque."""
    steps = problem.torque_steps
    if steps is None or steps.step[k] == 0.0:
        yield 0.0, 1.0, float(problem.u[k])
        return
    here = slice(k, k + 1)
    before, after = steps.take(here).around(problem.u[here])
    share = float(steps.share[k])
    yield 0.0, share, float(before[0])
    yield share, 1.0, float(after[0])


def _key(problem: Problem, first: int, stop: int, start: Array) -> str:
    """A hash of everything that decides the answer, the source of the joint's terms included."""
    joint, versions = problem.joint, (__version__, scipy.__version__)
    sources = [_source(type(term)) for _, term in joint.terms]
    settings = (joint.structure, joint.state_names, RTOL, ATOL, SMOOTHING, first, problem.begin)
    digest = hashlib.sha256(repr((*versions, *sources, *settings)).encode())
    for array in (problem.theta, problem.u[first:stop], start, np.array([problem.sampling_time])):
        digest.update(np.ascontiguousarray(array).tobytes())
    if problem.torque_steps is not None:
        within = problem.torque_steps.take(slice(first, stop))
        digest.update(np.stack([within.share, within.step]).tobytes())
    for name in sorted({MOTOR_ANGLE, *(term.companion_name for _, term in joint.terms)} & set(joint.companions)):
        digest.update(np.ascontiguousarray(joint.companions[name].samples).tobytes())
    return digest.hexdigest()


@cache
def _source(term: type[Term]) -> str:
    """The file that defines a term: while it is being written its version stays."""
    return Path(inspect.getfile(term)).read_text(encoding="utf-8")
