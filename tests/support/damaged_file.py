"""Files cut short, or with wrong bytes near their beginning."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robotid.errors import InputError
from robotid.signals.readers import read


def times_refused(path: Path, *, times: int, seed: int, head: int) -> int:
    """How often a file, damaged in turn at a random length and within its first `head` bytes, is refused; what is
    raised otherwise is raised here."""
    whole, rng, refused = path.read_bytes(), np.random.default_rng(seed), 0
    for k in range(times):
        content = bytearray(whole)
        if k % 2:
            content[int(rng.integers(len(whole))) :] = b""
        else:
            for at in rng.integers(min(len(whole), head), size=5):
                content[at] = int(rng.integers(256))
        path.write_bytes(content)
        try:
            read(path)
        except InputError:
            refused += 1
    return refused
