"""The one array type: double precision, samples on the last axis; and how its samples are gone through."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]


def blocks(n: int, size: int) -> Iterator[slice]:
    """Consecutive slices of at most `size` samples that cover 0 .. n - 1, so that memory does not grow with n."""
    for first in range(0, n, size):
        yield slice(first, min(n, first + size))
