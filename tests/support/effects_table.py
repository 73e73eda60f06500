"""Parts of the README that are made from the code, and how they are put there: `make readme`."""

from __future__ import annotations

from collections.abc import Iterable

from robotid.channels import CHANNELS
from robotid.model.channel import Channel
from robotid.model.describe import describe
from robotid.model.term import Term
from robotid.terms import TERMS
from support.paths import ROOT

README = ROOT / "README.md"
BEGIN, END = "<!-- effects -->", "<!-- end of effects -->"
TORQUES, SIGNALS = "torque that it absorbs", "signal after it"


def effects() -> str:
    """The catalogue as tables in Markdown: torques, then signals."""
    return f"{_table('acts at', TORQUES, TERMS.values())}\n\n{_table('acts on', SIGNALS, CHANNELS.values())}"


def with_effects(text: str) -> str:
    """A README with the tables between their marks."""
    before, _, rest = text.partition(BEGIN)
    return f"{before}{BEGIN}\n{effects()}\n{END}{rest.partition(END)[2]}"


def _table(place: str, formula: str, effects: Iterable[Term | Channel]) -> str:
    rows = (("effect", place, formula, "shows itself as", "source"), ("---",) * 5, *map(_row, effects))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _row(effect: Term | Channel) -> tuple[str, ...]:
    told = describe(effect)
    cells = (f"`{told.name}`", ", ".join(told.ports), f"`{told.formula}`", told.signature, told.source)
    return tuple(cell.replace("|", "\\|") for cell in cells)


if __name__ == "__main__":
    README.write_text(with_effects(README.read_text(encoding="utf-8")), encoding="utf-8")
