"""What the trials under conditions come to, condition by condition, in Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence

from study.conditional.trial import Result

HEAD = (
    "condition",
    "clean",
    "false causes",
    "with a visible effect",
    "first or its class",
    "no false cause",
    "in its interval",
)
STRANGE = ("stranger", "trials", "named as an effect", "verdicts")


def table(results: Sequence[Result]) -> str:
    """A line for each condition, and one for each stranger."""
    plain = [r for r in results if r.kind in ("clean", "effect")]
    lines = [_row(HEAD), _row(["---"] * len(HEAD))]
    lines += [_row(_condition(name, _of(plain, lambda r, n=name: r.condition == n))) for name in _names(plain)]
    strange = [r for r in results if r.kind in ("stranger", "both")]
    if strange:
        lines += ["", _row(STRANGE), _row(["---"] * len(STRANGE)), *map(_row, _strangers(strange))]
    return "\n".join(lines)


def _condition(name: str, results: Sequence[Result]) -> list[str]:
    clean, effects = _of(results, lambda r: r.kind == "clean"), _of(results, _shows)
    covered = [value for r in effects for value in r.covered.values()]
    wrong = sum(r.false > 0 or bool(r.error) for r in clean)
    return [
        name,
        str(len(clean)),
        f"{wrong} ({_percent([r.false > 0 or bool(r.error) for r in clean])})",
        f"{len(effects)} of {len(_of(results, lambda r: r.kind == 'effect'))}",
        _percent([r.first for r in effects]),
        _percent([r.false == 0 and not r.error for r in effects]),
        _percent(covered),
    ]


def _shows(result: Result) -> bool:
    return result.kind == "effect" and result.visible


def _strangers(results: Sequence[Result]) -> Iterator[list[str]]:
    for kind in ("stranger", "both"):
        for name in dict.fromkeys(r.name for r in results):
            own = _of(results, lambda r, n=name, k=kind: (r.name, r.kind) == (n, k))
            if own:
                counts = Counter(r.verdict for r in own)
                verdicts = ", ".join(f"{verdict} {count}" for verdict, count in counts.items())
                beside = " beside a true effect" if kind == "both" else ""
                yield [f"{name}{beside}", str(len(own)), _percent([r.false > 0 for r in own]), verdicts]


def _of(results: Sequence[Result], wanted: Callable[[Result], bool]) -> list[Result]:
    return [r for r in results if wanted(r)]


def _names(results: Sequence[Result]) -> list[str]:
    return list(dict.fromkeys(r.condition for r in results))


def _percent(good: Sequence[bool]) -> str:
    return f"{100 * sum(good) / len(good):.0f} %" if good else "-"


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
