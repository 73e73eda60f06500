"""Formulae as statements of a programming language, equal parts worked out once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from string import Template

from robotid.export.equations.node import FUNCTIONS, Node

INFIX = {
    "add": ("+", 1),
    "subtract": ("-", 1),
    "multiply": ("*", 2),
    "divide": ("/", 2),
    "less": ("<", 0),
    "greater": (">", 0),
    "less_equal": ("<=", 0),
    "greater_equal": (">=", 0),
}
"""Operators that all languages share, and how closely they bind."""

SIGN, TIGHT, ATOM = 2, 3, 4  # how closely a sign, a power and a name bind
LONGEST = 80  # characters of an operand before it gets a name of its own


@dataclass(frozen=True, slots=True)
class Language:
    """How a language writes what is not common to all.

    power : its operator; functions : names of functions, by operation; conditional : $condition, $yes and $no; end : of
    a statement.
    """

    power: str
    functions: Mapping[str, str]
    conditional: Template
    end: str = ""


RENAMED = {"absolute": "abs", "arctan": "atan", "minimum": "min", "maximum": "max"}
CALLED = {name: RENAMED.get(name, name) for name in (*FUNCTIONS, "absolute")}
PYTHON = Language("**", CALLED, Template("($yes if $condition else $no)"))
MATLAB = Language("^", CALLED, Template("pick($condition, $yes, $no)"), ";")


@dataclass(frozen=True, slots=True)
class _Text:
    text: str
    binds: int


class Writer:
    """Statements in one language. names : what a name of the formulae is called in it."""

    def __init__(self, language: Language, names: Mapping[str, str], prefix: str = "w") -> None:
        self.language, self.names, self.prefix = language, names, prefix
        self._known = dict[int, str]()  # what has a name of its own already
        self._numbers = dict[tuple[object, ...], int]()  # of different formulae
        self._nodes = dict[int, tuple[Node, int]]()  # the nodes are kept, for the id of one that is gone serves again

    def statements(self, wanted: Sequence[tuple[str, Node]]) -> list[str]:
        """Assignments of formulae to names, and before them those of their common parts."""
        uses = dict[int, int]()
        for _, node in wanted:
            self._count(node, uses)
        lines: list[str] = []
        for name, node in wanted:
            text = self._text(node, uses, lines).text
            lines.append(f"{name} = {text}{self.language.end}")
        return lines

    def _key(self, node: Node) -> int:
        """Number of a formula, equal for equal ones."""
        if id(node) not in self._nodes:
            content = (node.operation, node.name, node.value, *(self._key(one) for one in node.arguments))
            self._nodes[id(node)] = (node, self._numbers.setdefault(content, len(self._numbers)))
        return self._nodes[id(node)][1]

    def _count(self, node: Node, uses: dict[int, int]) -> None:
        key = self._key(node)
        uses[key] = uses.get(key, 0) + 1
        if uses[key] == 1:
            for one in node.arguments:
                self._count(one, uses)

    def _text(self, node: Node, uses: Mapping[int, int], lines: list[str]) -> _Text:
        key = self._key(node)
        if key in self._known:
            return _Text(self._known[key], ATOM)
        found = self._written(node, uses, lines)
        if not node.arguments or (uses.get(key, 0) < 2 and len(found.text) < LONGEST):
            return found
        if uses.get(key, 0) < 2 and node.operation in ("add", "subtract"):
            return found
        name = f"{self.prefix}{len(self._known) + 1}"
        lines.append(f"{name} = {found.text}{self.language.end}")
        self._known[key] = name
        return _Text(name, ATOM)

    def _written(self, node: Node, uses: Mapping[int, int], lines: list[str]) -> _Text:
        if node.operation == "number":
            return _Text(repr(node.value), ATOM if node.value >= 0 else SIGN)
        if node.operation == "name":
            return _Text(self.names.get(node.name, node.name), ATOM)
        inner = [self._text(one, uses, lines) for one in node.arguments]
        if node.operation == "where":
            parts = dict(zip(("condition", "yes", "no"), (one.text for one in inner), strict=True))
            return _Text(self.language.conditional.substitute(parts), ATOM)
        if node.operation == "negative":
            return _Text(f"-{_within(inner[0], TIGHT)}", SIGN)
        if node.operation == "power":
            return _Text(f"{_within(inner[0], ATOM)}{self.language.power}{_within(inner[1], ATOM)}", TIGHT)
        if node.operation in INFIX:
            operator, binds = INFIX[node.operation]
            return _Text(f"{_within(inner[0], binds)} {operator} {_within(inner[1], binds + 1)}", binds)
        return _Text(f"{self.language.functions[node.operation]}({', '.join(one.text for one in inner)})", ATOM)


def used_names(nodes: Sequence[Node]) -> Iterator[str]:
    """Names that formulae read, each once."""
    seen, stack, found = set[int](), list(nodes), dict[str, None]()
    while stack:
        node = stack.pop()
        if id(node) not in seen:
            seen.add(id(node))
            stack += node.arguments
            if node.operation == "name":
                found[node.name] = None
    yield from found


def _within(part: _Text, binds: int) -> str:
    return part.text if part.binds >= binds else f"({part.text})"
