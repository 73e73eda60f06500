"""Linear algebra on one thread."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

VARIABLES = ("OPENBLAS", "OMP", "MKL", "BLIS", "VECLIB_MAXIMUM")
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in VARIABLES}
"""Variables of the environment that hold linear algebra to one thread in a process that has yet to import it."""


@contextmanager
def one_thread() -> Iterator[None]:
    """Within this block linear algebra uses one thread: on matrices as small as those of a joint others only cost time,
    and they change the last bit of sums."""
    import scipy.linalg  # noqa: F401  it brings a library of its own, which is limited only once it is there

    try:
        from threadpoolctl import threadpool_limits
    except ImportError:  # the command line has set the environment; elsewhere the last bits are those of its threads
        yield
        return
    with threadpool_limits(limits=1, user_api="blas"):
        yield
