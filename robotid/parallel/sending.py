"""Objects on their way to another process and back: pickled, their arrays in a file that it maps into its memory."""

from __future__ import annotations

import pickle
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

ALIGNMENT = 64  # bytes, of arrays in a mapped file


def as_sent(content: Any) -> Any:
    """An object as another process would receive it, its arrays contiguous; those that are so already are shared."""
    buffers: list[pickle.PickleBuffer] = []
    image = pickle.dumps(content, protocol=5, buffer_callback=buffers.append)
    return pickle.loads(image, buffers=[buffer.raw().toreadonly() for buffer in buffers])


def write(file: Path, content: Any, least: int = 0) -> bool:
    """Write an object to a file that other processes map into their memory: a table of lengths, what is pickled, and
    the arrays. least : bytes of arrays, below which nothing is written. Returns whether it was."""
    buffers: list[pickle.PickleBuffer] = []
    image = pickle.dumps(content, protocol=5, buffer_callback=buffers.append)
    parts: list[Any] = [image, *(buffer.raw() for buffer in buffers)]
    if sum(map(len, parts[1:])) < least:
        return False
    table = pickle.dumps([len(part) for part in parts])
    with open(file, "wb") as stream:
        for part in (len(table).to_bytes(8, "little"), table, *parts):
            stream.write(bytes(-stream.tell() % ALIGNMENT))
            stream.write(part)
    return True


def read(file: str) -> Any:
    """The object that such a file holds; its arrays lie in the file."""
    with open(file, "rb") as stream:
        mapped = memoryview(mmap(stream.fileno(), 0, access=ACCESS_READ))
    at = 0

    def following(length: int) -> memoryview:
        nonlocal at
        at += -at % ALIGNMENT
        found = mapped[at : at + length]
        at += length
        return found

    table = following(int.from_bytes(following(8), "little"))
    image, *buffers = [following(length) for length in pickle.loads(table)]
    return pickle.loads(image, buffers=buffers)
