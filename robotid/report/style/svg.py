"""Figures inside a page: SVG whose colours are the page's, so that it can be dark, and whose text is text."""

from __future__ import annotations

import re
from io import StringIO

from matplotlib import rc_context
from matplotlib.figure import Figure

from robotid.report.style.axes import BAND, BLUE, FAINT, GREEN, GRID, INK, ORANGE, PURPLE, QUIET, SKY, VERMILLION

COLOURS = {
    INK: "ink",
    FAINT: "faint",
    QUIET: "quiet",
    GRID: "grid",
    BAND: "band",
    BLUE: "blue",
    VERMILLION: "vermillion",
    GREEN: "green",
    PURPLE: "purple",
    SKY: "sky",
    ORANGE: "orange",
}
"""Custom properties of the page's style sheet."""

PROLOGUE = re.compile(r"^.*?(?=<svg)|<metadata>.*?</metadata>|<!--.*?-->", re.DOTALL)
NAMESPACE = re.compile(r' xmlns(:\w+)?="[^"]*"| version="[^"]*"')
SIZE = re.compile(r'(<svg[^>]*?) width="([\d.]+)pt" height="[\d.]+pt"')
BIN = re.compile(r' id="bin-(\d+)"')
"""An element that stands for a bin of a curve, so that the page can tell it."""
ENLARGED = 1.45  # most pixels for a point: letters of 9 pt become 13 px
IDENTIFIER = re.compile(r' id="([^"]*)"')
FAMILY = re.compile(r"font-family: [^;\"]*;? ?")
NO_IDENTIFIER = re.compile(r"[^A-Za-z0-9_-]")
TAG = re.compile(r"<[^>]+>")
DIGITS = re.compile(r"(\d+\.\d{2})\d+")


def identifier(name: str) -> str:
    """A name as an identifier of HTML: names come from files, and quotes or angle brackets would end an attribute."""
    return NO_IDENTIFIER.sub("-", name)


def inline(figure: Figure, name: str) -> str:
    """A figure as an element of HTML, without reference to anything outside. name : makes its identifiers its own."""
    stream, name = StringIO(), identifier(name)
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure.savefig(stream, format="svg", transparent=True, metadata={"Date": None})
    text = NAMESPACE.sub("", PROLOGUE.sub("", stream.getvalue())).replace("xlink:href", "href")
    text = FAMILY.sub("", SIZE.sub(_natural_width, text))
    text = BIN.sub(r' data-bin="\1"', text)
    text = _own_identifiers(text, name)
    for colour, role in COLOURS.items():
        text = text.replace(colour.lower(), f"var(--{role})").replace(colour, f"var(--{role})")
    return TAG.sub(lambda tag: DIGITS.sub(r"\1", tag.group()), text)


def _natural_width(size: re.Match[str]) -> str:
    """As wide as the page likes, but never so wide that letters are larger than its text. Its own width stands beside
    that, so that on paper all letters are of one size."""
    return f'{size[1]} style="max-width: {ENLARGED * float(size[2]):.0f}px; --points: {float(size[2]):.0f}"'


def _own_identifiers(text: str, name: str) -> str:
    """Only identifiers that are referred to, and none that another figure has."""
    used = set(re.findall(r'href="#([^"]*)"|url\(#([^)]*)\)', text))
    wanted = {found for pair in used for found in pair if found}
    text = IDENTIFIER.sub(lambda m: m.group(0) if m.group(1) in wanted else "", text)
    return re.sub(r'( id="|href="#|url\(#)', rf"\g<1>{name}-", text)
