"""Figures as files."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from robotid.errors import ConfigError

FORMATS = ("png", "svg", "pdf")
DENSITY = 150  # [dots/inch] of pixels


def check_format(form: str, where: str) -> None:
    """Raises ConfigError for a format that cannot be drawn. where : what asked for it."""
    if form not in FORMATS:
        hint = f"use {', '.join(FORMATS)}"
        raise ConfigError(f'no figure can be written as "{form}"', where=where, hint=hint)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure, whole or not at all, in the format that the file's ending names. Raises OSError."""
    part = path.with_name(f".{path.stem}.part{path.suffix}")
    try:
        figure.savefig(part, dpi=DENSITY)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
