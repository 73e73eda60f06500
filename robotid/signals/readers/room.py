"""Whether what a file declares can be read: sizes are compared before anything is unpacked."""

from __future__ import annotations

import os
from pathlib import Path

from robotid.errors import InputError

SMALL = 64_000_000  # [bytes] that are read whatever the file's own size
MAX_EXPANSION = 200  # declared over stored: measurements, which hold noise, never pack so well
MEMORY_SHARE = 0.25  # of the memory at hand that one column may take; it is copied a few times on its way


def require_room(path: Path, name: str, size: int) -> None:
    """Raises InputError where a column, or a file, declares more bytes than can be unpacked from it or than there is
    memory for. name : what declares it."""
    if size <= SMALL:
        return
    stored = path.stat().st_size
    if size > MAX_EXPANSION * stored:
        what = f"{name} declares {in_words(size)} in a file of {in_words(stored)}: that is no recording"
        raise InputError(what, where=str(path), hint="save the recorded signals alone")
    memory = available_memory()
    if size > MEMORY_SHARE * memory:
        what = f"{name} takes {in_words(size)}, and {in_words(memory)} of memory are free"
        raise InputError(what, where=str(path), hint="cut the recording into shorter ones")


def available_memory() -> int:
    """Memory that is free [bytes], or all there is where the system does not tell."""
    try:
        with open("/proc/meminfo", encoding="ascii") as facts:
            return next(1024 * int(line.split()[1]) for line in facts if line.startswith("MemAvailable:"))
    except (OSError, StopIteration, ValueError):
        pages = getattr(os, "sysconf", lambda name: 0)("SC_PHYS_PAGES")
        return int(pages) * int(os.sysconf("SC_PAGE_SIZE")) if pages > 0 else 2**62


def in_words(size: float) -> str:
    """A size in decimal units: 5.1 GB."""
    for unit in ("bytes", "kB", "MB", "GB", "TB"):
        if size < 1000 or unit == "TB":
            break
        size /= 1000
    return f"{size:.3g} {unit}"
