"""The one array type: double precision, samples on the last axis; and how its samples are gone through."""

from collections.abc import Iterator
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]
Sampled = TypeVar("Sampled", Array, Mask)


def blocks(n: int, size: int) -> Iterator[slice]:
    """Consecutive slices of at most `size` samples that cover 0 .. n - 1, so that memory does not grow with n."""
    for first in range(0, n, size):
        yield slice(first, min(n, first + size))


def taken(a: Sampled, at: Index | slice) -> Sampled:
    """The samples `at` of a (..., n), each row in one piece of memory: an index alone would lay them across, and slow
    down all that reads them."""
    return a[..., at] if isinstance(at, slice) else a.take(at, axis=-1)
