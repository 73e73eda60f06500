"""What can go wrong, in one line: where, what, what to do. One exit code a class."""

from __future__ import annotations

import unicodedata
from typing import ClassVar

INTERRUPTED = 130  # the exit code of what was stopped from the keyboard or by SIGTERM

LONGEST = 1000  # characters of an error that are shown


def printable(text: str, keep: str = "") -> str:
    """A text with its control characters written out, \\x1b say, so that no file steers the terminal that shows its
    names. keep : control characters that stay, such as a line feed. Bytes of a file name that are no text are written
    out as well."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep or unicodedata.category(c) == "Zs" else _escaped(c) for c in text)


def _short(text: str) -> str:
    """A text that quotes what a file holds, however long that is."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 2 :]}"


def _escaped(character: str) -> str:
    code = ord(character)
    if 0xDC80 <= code <= 0xDCFF:  # how Python hands on a byte that is no text (PEP 383)
        return f"\\x{code - 0xDC00:02x}"
    return character.encode("unicode_escape").decode()


class RobotidError(Exception):
    """Base of every error that a person can correct.

    what : what is wrong; where : file, line or name it concerns; hint : what to do about it.
    """

    exit_code: ClassVar[int] = 1

    def __init__(self, what: str, *, where: str = "", hint: str = "") -> None:
        super().__init__(what, where, hint)
        self.what, self.where, self.hint = what, where, hint

    def __reduce__(self) -> tuple[object, ...]:
        return _rebuilt, (type(self), self.what, self.where, self.hint)

    def __str__(self) -> str:
        line = f"{self.where}: {_short(self.what)}" if self.where else _short(self.what)
        return printable(f"{line}; {self.hint}" if self.hint else line)


def _rebuilt(kind: type[RobotidError], what: str, where: str, hint: str) -> RobotidError:
    """An error as another process raised it."""
    return kind(what, where=where, hint=hint)


class ConfigError(RobotidError):
    """The command line or the configuration says something that cannot be done."""

    exit_code = 2


class InputError(RobotidError):
    """An input file or artifact is missing, stale, foreign or damaged."""

    exit_code = 3


class NumericsError(RobotidError):
    """The numbers do not allow it: no convergence, no excitation, not identifiable."""

    exit_code = 4


class ThresholdError(RobotidError):
    """The validation stayed below the threshold that the configuration demands."""

    exit_code = 5
