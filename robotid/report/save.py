"""Figures as files, for papers and slides."""

from __future__ import annotations

import re
from collections.abc import Callable
from io import BytesIO
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from robotid.errors import ConfigError
from robotid.files import atomic_write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")
LETTERS = 8.0  # [pt] of ticks and legends as figures are drawn
READABLE = 5.0  # [pt] the least that publishers accept
SIDE = re.compile(r'\b(width|height)="([\d.]+)pt"')
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


def save_figure(figure: Figure, path: Path, size: Size | None = None) -> float:
    """Write a figure in the format that the file's ending names.

    size : absent, as it was drawn. In a smaller one the whole figure shrinks, letters and lines too, so that nothing
    overlaps that did not before; a larger one gives room to the curves. Returns by how much it shrank, 1 where it did
    not. Raises InputError where the file cannot be written.
    """
    from matplotlib import rc_context

    shrunk = 1.0
    if size is not None:
        width, height = size.width / INCH, size.height / INCH
        drawn = figure.get_size_inches()
        shrunk = min(1.0, width / float(drawn[0]), height / float(drawn[1]))
        figure.set_size_inches(width / shrunk, height / shrunk)
    form = path.suffix.removeprefix(".")
    with rc_context(AS_TEXT):
        image = WRITERS[form](figure, shrunk)
    atomic_write(path, image)
    return shrunk


def _png(figure: Figure, shrunk: float) -> bytes:
    image = BytesIO()
    figure.savefig(image, format="png", dpi=DENSITY * shrunk, pil_kwargs={"dpi": (DENSITY, DENSITY)})
    return image.getvalue()


def _svg(figure: Figure, shrunk: float) -> bytes:
    """The view box keeps the units in which the figure was drawn."""
    image = BytesIO()
    figure.savefig(image, format="svg")
    before, root, after = image.getvalue().decode("utf-8").partition("<svg")
    head, end, rest = after.partition(">")
    head = SIDE.sub(lambda found: f'{found[1]}="{float(found[2]) * shrunk:.6f}pt"', head)
    return f"{before}{root}{head}{end}{rest}".encode()


def _pdf(figure: Figure, shrunk: float) -> bytes:
    """The first operator of the page makes all units smaller."""
    from matplotlib.backends.backend_pdf import Op, PdfPages

    image = BytesIO()
    pages: Any = PdfPages(image)
    file = pages._ensure_file()
    begin = file.newPage

    def begin_shrunk(width: float, height: float) -> None:
        begin(shrunk * width, shrunk * height)
        file.width, file.height = width, height  # beyond which paths are cut
        file.output(shrunk, 0, 0, shrunk, 0, 0, Op.concat_matrix)

    file.newPage = begin_shrunk
    pages.savefig(figure, dpi=DENSITY)
    pages.close()
    return image.getvalue()


WRITERS: Final[dict[str, Callable[[Figure, float], bytes]]] = {"png": _png, "svg": _svg, "pdf": _pdf}


def letters_remark(shrunk: float, name: str, size: Size | None) -> str:
    """What to say of a figure whose letters became too small to be read on paper, empty where they did not."""
    if size is None or shrunk * LETTERS >= READABLE:
        return ""
    more = READABLE / (shrunk * LETTERS)
    enough = f"{ceil(size.width * more)}x{ceil(size.height * more)}"
    return f"letters of {name} are {shrunk * LETTERS:.1f} points high; --size {enough} makes them {READABLE:g}"
