"""The standard streams as they come: closed, full, broken, or of an encoding that lacks half of our characters.

A result that nobody reads any more is no failure, and neither is talk that cannot be shown: what has been computed is
saved, and the exit code is that of the work. Only a result that could not be written, on a full disk say, is an error.
"""

from __future__ import annotations

import codecs
import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO, cast

from robotid.interrupt import blocking

PLAIN = {
    "─": "-",
    "━": "-",
    "−": "-",
    "–": "-",
    "·": "*",
    "×": "x",
    "→": "->",
    "±": "+-",
    "²": "2",
    "³": "3",
    "°": "deg",
    "µ": "u",
    "\u00a0": " ",
    **{power: f"^{digit}" for power, digit in zip("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789", strict=True)},
}
"""What a terminal that lacks a character shows instead; a question mark for all others."""


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(PLAIN.get(c, "?") for c in error.object[error.start : error.end]), error.end


codecs.register_error("robotid.plain", _plain)


class Output:
    """A text stream that never raises: what cannot be written is left out, and the first failure is kept.

    failure : None where all could be written, or where the reader has gone.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._lost = stream, False
        self.failure: OSError | None = None

    def write(self, text: str) -> int:
        """Write what the encoding can hold. Raises Interrupted alone."""
        if not self._lost:
            try:
                with blocking():
                    self._stream.write(self._encodable(text))
            except OSError as error:
                self._give_up(error)
        return len(text)

    def flush(self) -> None:
        """Hand on what is buffered."""
        if not self._lost:
            try:
                with blocking():
                    self._stream.flush()
            except OSError as error:
                self._give_up(error)

    def _encodable(self, text: str) -> str:
        encoding = self._stream.encoding or "utf-8"
        try:
            text.encode(encoding)
        except UnicodeEncodeError:
            return text.encode(encoding, "robotid.plain").decode(encoding)
        return text

    def _give_up(self, error: OSError) -> None:
        self._lost = True
        if error.errno != errno.EPIPE:
            self.failure = error
        with suppress(OSError, ValueError):  # the interpreter flushes what is left when it ends
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def standard_streams() -> Iterator[Output]:
    """Streams that never raise, in place of stdout and stderr; gives that of the results."""
    _occupy_descriptors()
    former = sys.stdout, sys.stderr
    nowhere = open(os.devnull, "w", encoding="utf-8") if None in former else None  # noqa: SIM115
    results, talk = (Output(cast(TextIO, stream or nowhere)) for stream in former)
    sys.stdout, sys.stderr = cast(TextIO, results), cast(TextIO, talk)
    try:
        yield results
    finally:
        results.flush()
        talk.flush()
        sys.stdout, sys.stderr = former
        if nowhere is not None:
            nowhere.close()


def _occupy_descriptors() -> None:
    """A file that is opened while a standard stream is closed would get its number, and its messages."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
