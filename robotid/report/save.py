"""Figures as files."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from robotid.errors import ConfigError
from robotid.files import atomic_write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")
DENSITY = 150  # [dots/inch] of pixels


def check_format(form: str, where: str) -> None:
    """Raises ConfigError for a format that cannot be drawn. where : what asked for it."""
    if form not in FORMATS:
        hint = f"use {', '.join(FORMATS)}"
        raise ConfigError(f'no figure can be written as "{form}"', where=where, hint=hint)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure in the format that the file's ending names. Raises InputError where that fails."""
    image = BytesIO()
    figure.savefig(image, format=path.suffix.removeprefix("."), dpi=DENSITY)
    atomic_write(path, image.getvalue())
