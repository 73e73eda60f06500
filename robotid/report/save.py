"""Figures as files, for papers and slides."""

from __future__ import annotations

import re
import warnings
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from robotid.errors import ConfigError
from robotid.files import atomic_write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")
DENSITY = 300  # [dots/inch] of pixels: what journals ask for
INCH = 25.4  # [mm]
SIZE = re.compile(r"(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)")
SMALLEST, LARGEST = 20.0, 2000.0  # [mm] of a side
AS_TEXT: Final[Any] = {"pdf.fonttype": 42, "ps.fonttype": 42, "svg.fonttype": "none"}
"""Letters stay letters: TrueType in PDF (Type 3 is what journals refuse), text in SVG."""


class Size(NamedTuple):
    """Width and height of a figure [mm]."""

    width: float
    height: float


def check_format(form: str, where: str) -> None:
    """Raises ConfigError for a format that cannot be drawn. where : what asked for it."""
    if form not in FORMATS:
        hint = f"use {', '.join(FORMATS)}"
        raise ConfigError(f'no figure can be written as "{form}"', where=where, hint=hint)


def parse_size(text: str | None) -> Size | None:
    """A size such as 88x60, in millimetres. Raises ConfigError for anything else."""
    if text is None:
        return None
    found = SIZE.fullmatch(text.strip().lower())
    sides = [float(side) for side in found.groups()] if found else []
    if not sides or not all(SMALLEST <= side <= LARGEST for side in sides):
        hint = f"give width and height in millimetres, {SMALLEST:g} to {LARGEST:g}, such as 88x60"
        raise ConfigError(f'"{text}" is no size of a figure', where="--size", hint=hint)
    return Size(*sides)


def save_figure(figure: Figure, path: Path, size: Size | None = None) -> None:
    """Write a figure in the format that the file's ending names. size : absent, as it was drawn. Raises ConfigError
    where it does not fit, InputError where the file cannot be written."""
    from matplotlib import rc_context

    if size is not None:
        figure.set_size_inches(size.width / INCH, size.height / INCH)
    image = BytesIO()
    with rc_context(AS_TEXT), warnings.catch_warnings():
        warnings.filterwarnings("error", message="constrained_layout not applied")
        try:
            figure.savefig(image, format=path.suffix.removeprefix("."), dpi=DENSITY)
        except UserWarning as error:
            what = f"the figure for {path.name} has no room in that size"
            raise ConfigError(what, where="--size", hint="make it larger, or leave --size out") from error
    atomic_write(path, image.getvalue())
