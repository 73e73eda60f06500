"""LSODA where Newton's method fails, with a cache on disk: slow, robust, and asked the same thing again by every fit.

The cache holds plain .npy files named by a hash of everything that decides the answer, the source of the joint's terms
included. It is bounded in size (the oldest files go first), safe to delete at any time, and lives in ROBOTID_CACHE, or
robotid/ in the user's cache folder.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import tempfile
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from scipy.integrate import solve_ivp

from robotid import __version__
from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.term import Term
from robotid.simulate.newton.solver import RUNAWAY, Problem

_solve_ivp: Any = solve_ivp  # its types take every right-hand side for complex

RTOL, ATOL = 1e-8, 1e-11
SMOOTHING = 1e-4  # rad/s: LSODA needs a continuous friction law
LARGEST_CACHE = 64_000_000  # bytes


def lsoda(problem: Problem, first: int, stop: int, start: Array) -> Array:
    """Nodes first .. stop by LSODA from start (nx,), (nx, stop - first + 1). Raises NumericsError on divergence."""
    if len(problem.joint.terms) != len(problem.joint.structure.terms):  # a term that has no name yet
        return _integrate(problem, first, stop, start)
    file = cache_folder() / f"{_key(problem, first, stop, start)}.npy"
    try:
        return np.asarray(np.load(file, allow_pickle=False))
    except (EOFError, OSError, ValueError):
        x = _integrate(problem, first, stop, start)
    _store(file, x)
    return x


def cache_folder() -> Path:
    """Where the cache lives."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(os.environ.get("ROBOTID_CACHE") or Path(home) / "robotid")


def smooth_rate(joint: Joint, x: Array, u: float, t: float, theta: Array) -> Array:
    """dx/dt at one state x (nx,) with sgn(v) smoothed as v / sqrt(v^2 + eps^2), (nx,)."""
    v = x[joint.speeds, None]
    s = v / np.sqrt(v**2 + SMOOTHING**2)
    return joint.evaluate(x[:, None], np.array([u]), s, np.array([t]), theta).f[:, 0]


@np.errstate(all="ignore")  # what runs away is told below
def _integrate(problem: Problem, first: int, stop: int, start: Array) -> Array:
    h, x = problem.sampling_time, [start]
    for k in range(first, stop):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # that it failed is told below
            step = _solve_ivp(
                lambda t, y, k=k: smooth_rate(problem.joint, y, float(problem.u[k]), t, problem.theta),
                (problem.begin + k * h, problem.begin + (k + 1) * h),
                x[-1],
                method="LSODA",
                rtol=RTOL,
                atol=ATOL,
            )
        if not step.success or not np.abs(step.y[:, -1]).max() < RUNAWAY:
            raise NumericsError(
                f"the simulation diverges at t = {k * h:.4g} s", hint="check the parameters' guesses and bounds"
            )
        x.append(step.y[:, -1])
    return np.stack(x, axis=1)


def _key(problem: Problem, first: int, stop: int, start: Array) -> str:
    joint, versions = problem.joint, (__version__, scipy.__version__)
    sources = [_source(type(term)) for _, term in joint.terms]
    settings = (joint.structure, joint.state_names, RTOL, ATOL, SMOOTHING, first, problem.begin)
    digest = hashlib.sha256(repr((*versions, *sources, *settings)).encode())
    for array in (problem.theta, problem.u[first:stop], start, np.array([problem.sampling_time])):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


@cache
def _source(term: type[Term]) -> str:
    """The file that defines a term: while it is being written its version stays."""
    return Path(inspect.getfile(term)).read_text(encoding="utf-8")


def _store(file: Path, x: Array) -> None:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        handle, part = tempfile.mkstemp(dir=file.parent, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as stream:
                np.save(stream, x, allow_pickle=False)
            os.replace(part, file)
        finally:
            Path(part).unlink(missing_ok=True)
        _shrink(file.parent)
    except OSError:
        return  # a cache that cannot be written costs time, not results


def _shrink(folder: Path) -> None:
    files = sorted(folder.glob("*.npy"), key=lambda f: f.stat().st_mtime)
    size = sum(f.stat().st_size for f in files)
    for file in files:
        if size <= LARGEST_CACHE:
            return
        size -= file.stat().st_size
        file.unlink(missing_ok=True)
