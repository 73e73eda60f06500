"""The pages of the manual, their commands, and the blocks between marks that are made from the code."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from support.manual.checks import checks
from support.manual.configuration import sections
from support.manual.effects import catalogue, details
from support.manual.interface import interface
from support.manual.options import own_options
from support.paths import ROOT

README = ROOT / "README.md"
FOLDER = ROOT / "robotid" / "docs"
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"`((?:robotid|make|pip) [^`]+)`")
BLOCKS: Mapping[str, Callable[[], str]] = {
    "effects": catalogue,
    "parameters of effects": details,
    "settings": sections,
    "interface": interface,
    "checks": checks,
    "options": own_options,
}
"""Makers of what stands between `<!-- name -->` and `<!-- end of name -->`."""


@dataclass(frozen=True)
class Page:
    """One page of the manual, or the README."""

    path: Path

    @cached_property
    def text(self) -> str:
        """The page as it is."""
        return self.path.read_text(encoding="utf-8")

    def fenced(self, kind: str) -> list[str]:
        """The blocks of code of one language, in order."""
        return [block for found, block in FENCE.findall(self.text) if found == kind]

    @property
    def shown(self) -> list[str]:
        """Commands of the page's shell blocks, in order, without comments and folders to change to."""
        lines = [line for block in self.fenced("sh") for line in block.splitlines()]
        return [" ".join(shlex.split(line, comments=True)) for line in lines if line.strip()]

    @property
    def inline(self) -> list[str]:
        """Commands in the running text that are complete enough to be tried."""
        return list(dict.fromkeys(INLINE.findall(FENCE.sub("", self.text))))


def pages() -> list[Page]:
    """The README, then the pages of the manual by name."""
    return [Page(README), *map(Page, sorted(FOLDER.glob("*.md")))]


def renewed(text: str) -> str:
    """A page with every block that the code decides as the code has it now."""
    for name, make in BLOCKS.items():
        if f"<!-- {name} -->" in text:
            text = replaced(text, name, make())
    return text


def replaced(text: str, name: str, block: str) -> str:
    """A page with another block between the marks of that name. Raises ValueError where a mark is missing."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    if text.count(begin) != 1 or text.count(end) != 1:
        raise ValueError(f"{begin} and {end} must stand in the page once each")
    before, _, rest = text.partition(begin)
    return f"{before}{begin}\n\n{block.strip()}\n\n{end}{rest.partition(end)[2]}"
