"""The table of the study, effect by effect, with the goals, as text and inside the manual."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from study.trials.judgement import SHARE, WORTH, Judgement, judge
from study.trials.trial import Result

PAGE = Path("robotid/docs/validation.md")
BEGIN, END = "<!-- trials -->", "<!-- end of trials -->"
HEAD = ("hidden", "trials", "first", "first or its class", "false causes", "missed", "oracle's gain")
Judged = tuple[Result, Judgement]


def table(results: Sequence[Result]) -> str:
    """Goals reached, then a line for each effect, in Markdown."""
    judged = [(r, judge(r)) for r in results]
    worth, below = ([pair for pair in judged if pair[1].worth is wanted] for wanted in (True, False))
    effects, other = _of(worth, "effect"), [pair for pair in worth if pair[0].kind != "effect"]
    lines = [*_goals(worth), "", *_rows(HEAD), *_by_name(effects)]
    lines += [row for kind in ("clean", "pair") for row in _line(_of(other, kind), kind)]
    lines += [row for name in _names(_of(other, "unknown")) for row in _line(_named(other, name), f"unknown: {name}")]
    if below:
        hits = sum(j.in_class for _, j in below)
        lines += [
            "",
            f"{len(below)} more trials cost less than {WORTH:g} noise standard deviations; {hits} were right.",
        ]
    return "\n".join(lines)


def write(page: Path, text: str) -> None:
    """Put the table between its marks. Raises ValueError where the page lacks them."""
    before, begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"{page} lacks the marks {BEGIN} and {END}")
    page.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")


def _goals(judged: Sequence[Judged]) -> Iterator[str]:
    yield from _rows(("of trials that cost at least 3 noise standard deviations", "goal", "reached"))
    asked: list[tuple[str, float, str, Callable[[Judged], bool]]] = [
        ("the effect is in the first cause's class", 95, "effect", lambda p: p[1].in_class),
        ("the effect is first", 85, "effect", lambda p: p[1].right),
        ("clean: no cause named", 98, "clean", lambda p: p[1].right),
        ("pairs: both named, or in a cause's class", 85, "pair", lambda p: p[1].in_class),
        ("unknown: recognised", 85, "unknown", lambda p: p[1].right),
        ("unknown: shape with a correlation of 0.95", 85, "unknown", lambda p: p[1].shape),
        (f"gain at least {100 * SHARE:g} % of the oracle's", 95, "effect", lambda p: p[1].share >= SHARE),
    ]
    for what, goal, kind, good in asked:
        of = _of(judged, kind)
        yield _row((what, f"{goal} %", f"{_percent([good(p) for p in of])} of {len(of)}"))


def _by_name(judged: Sequence[Judged]) -> Iterator[str]:
    for name in sorted(_names(judged)):
        yield from _line(_named(judged, name), name)
    yield from _line(judged, "all effects")


def _line(judged: Sequence[Judged], name: str) -> Iterator[str]:
    if not judged:
        return
    all_of = [j for _, j in judged]
    shares = [j.share for j in all_of if np.isfinite(j.share)]
    yield _row(
        (
            name,
            str(len(judged)),
            _percent([j.right for j in all_of]),
            _percent([j.in_class for j in all_of]),
            str(sum(j.false for j in all_of)),
            str(sum(j.missed for j in all_of)),
            f"{100 * np.median(shares):.1f} %" if shares else "",
        )
    )


def _of(judged: Sequence[Judged], kind: str) -> list[Judged]:
    return [pair for pair in judged if pair[0].kind == kind]


def _named(judged: Sequence[Judged], name: str) -> list[Judged]:
    return [pair for pair in judged if pair[0].hidden == (name,)]


def _names(judged: Sequence[Judged]) -> list[str]:
    return list(dict.fromkeys(r.hidden[0] for r, _ in judged))


def _percent(good: Sequence[bool]) -> str:
    return f"{100 * np.mean(good):.0f} %" if good else "-"


def _rows(head: Sequence[str]) -> list[str]:
    return [_row(head), _row(["---"] * len(head))]


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
