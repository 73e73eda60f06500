"""A reader of the part of MATLAB that exported functions are written in: its grammar, its precedence, indices from one.

It knows functions, if and else, return, assignments to names and fields, matrices, and the functions in CALLED. What it
does not know it refuses: a name that nothing defines, a statement without a semicolon, a block without an end.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

CALLED: dict[str, Callable[..., Any]] = {
    **{
        name: getattr(math, name)
        for name in ("exp", "log", "sin", "cos", "tan", "tanh", "cosh", "sinh", "atan", "sqrt")
    },
    **{"abs": abs, "min": min, "max": max, "floor": math.floor, "struct": dict, "sign": lambda v: float(np.sign(v))},
}
KEYWORDS = {"function", "if", "else", "end", "return"}
TOKEN = re.compile(
    r"(?P<space>[ \t]+)|(?P<note>%[^\n]*)|(?P<line>\n)|(?P<number>(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?)"
    r"|(?P<name>[A-Za-z]\w*)|(?P<mark>[<>]=?|==|[-+*/\\^()\[\],;=.])"
)
COMPARE = {
    "<": lambda a, b: a < b,
    ">": lambda a, b: a > b,
    "<=": lambda a, b: a <= b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
}


@dataclass(frozen=True)
class Token:
    kind: str
    text: str
    spaced: bool  # whether there is a space before it


class Return(Exception):
    """The end of a function before its last line."""


@dataclass
class Function:
    """A function of the file. block : what runs it."""

    name: str
    result: str
    parameters: list[str]
    block: list[Any] = field(default_factory=list)


def tokens(text: str) -> Iterator[Token]:
    at, spaced = 0, False
    while at < len(text):
        found = TOKEN.match(text, at)
        assert found, f"not MATLAB: {text[at : at + 30]!r}"
        kind = found.lastgroup or ""
        for name in ("space", "note", "line", "number", "name", "mark"):
            kind = name if found.group(name) is not None else kind
        if kind not in ("space", "note"):
            yield Token(kind, found.group(), spaced)
        spaced, at = kind == "space", found.end()
    yield Token("line", "\n", False)
    yield Token("end of file", "", False)


class Matlab:
    """A file of functions, to be called by name."""

    def __init__(self, text: str) -> None:
        self.tokens, self.at = list(tokens(text)), 0
        self.functions: dict[str, Function] = {}
        self.matrix = 0  # depth of brackets, within which a space may separate
        self.skip()
        while self.now.kind != "end of file":
            one = self.function()
            self.functions[one.name] = one
            self.skip()

    @property
    def now(self) -> Token:
        return self.tokens[self.at]

    def take(self, *texts: str) -> str:
        token = self.now
        assert not texts or token.text in texts, f"{texts} expected, there is {token.text!r}"
        self.at += 1
        return token.text

    def skip(self) -> None:
        while self.now.kind == "line":
            self.at += 1

    def name(self) -> str:
        assert self.now.kind == "name", f"a name expected, there is {self.now.text!r}"
        assert self.now.text not in KEYWORDS
        return self.take()

    # --- the grammar

    def function(self) -> Function:
        self.take("function")
        result = self.name()
        self.take("=")
        name = self.name()
        self.take("(")
        parameters = [self.name()]
        while self.take(",", ")") == ",":
            parameters.append(self.name())
        return Function(name, result, parameters, self.block("end"))

    def block(self, *ends: str) -> list[Any]:
        found: list[Any] = []
        self.take("\n")
        self.skip()
        while self.now.text not in ends:
            found.append(self.statement())
            self.skip()
        if ends == ("end",):
            self.take("end")
        return found

    def statement(self) -> Any:
        if self.now.text == "if":
            self.take()
            condition = self.compared()
            yes = self.block("else", "end")
            no = self.block("end") if self.take("else", "end") == "else" else []
            return ("if", condition, yes, no)
        if self.now.text == "return":
            self.take()
            self.take("\n")
            return ("return",)
        target, part = self.name(), ""
        if self.now.text == ".":
            self.take()
            part = self.name()
        self.take("=")
        value = self.compared()
        self.take(";")
        self.take("\n")
        return ("set", target, part, value)

    def compared(self) -> Any:
        return self.chain(
            tuple(COMPARE), lambda: self.chain(("+", "-"), lambda: self.chain(("*", "/", "\\"), self.signed))
        )

    def chain(self, operators: Sequence[str], inner: Callable[[], Any]) -> Any:
        left = inner()
        while self.now.text in operators and not self.separates():
            left = (self.take(), left, inner())
        return left

    def separates(self) -> bool:
        """Whether a sign begins an element of a matrix: with a space before it, and none behind."""
        return self.matrix > 0 and self.now.text in "+-" and self.now.spaced and not self.tokens[self.at + 1].spaced

    def signed(self) -> Any:
        if self.now.text in ("+", "-"):
            return ("sign", self.take(), self.signed())
        left = self.called()
        while self.now.text == "^":
            self.take()
            signs = [self.take() for _ in iter(lambda: self.now.text in ("+", "-"), False)]
            right = self.called()
            for sign in reversed(signs):
                right = ("sign", sign, right)
            left = ("^", left, right)
        return left

    def called(self) -> Any:
        found = self.primary()
        while self.now.text in ("(", ".") and not (self.matrix and self.now.spaced):
            if self.take() == ".":
                found = ("field", found, self.name())
                continue
            depth, self.matrix, given = self.matrix, 0, []
            while self.now.text != ")":
                given.append(self.compared())
                if self.now.text != ")":
                    self.take(",")
            self.take(")")
            self.matrix, found = depth, ("call", found, given)
        return found

    def primary(self) -> Any:
        if self.now.kind == "number":
            return ("number", float(self.take()))
        if self.now.text == "(":
            self.take()
            depth, self.matrix = self.matrix, 0
            inner = self.compared()
            self.take(")")
            self.matrix = depth
            return inner
        if self.now.text == "[":
            return self.rows()
        return ("name", self.name())

    def rows(self) -> Any:
        self.take("[")
        self.matrix += 1
        rows: list[list[Any]] = [[]]
        while self.now.text != "]":
            rows[-1].append(self.compared())
            if self.now.text == ";":
                self.take()
                rows.append([])
            elif self.now.text == ",":
                self.take()
            else:
                assert self.now.text == "]" or self.now.spaced, f"in a matrix: {self.now.text!r}"
        self.take("]")
        self.matrix -= 1
        return ("matrix", rows)

    # --- what it does

    def call(self, name: str, *given: Any) -> Any:
        """The result of a function of the file."""
        one = self.functions[name]
        assert len(given) <= len(one.parameters), f"{name} takes {len(one.parameters)}"
        known = {**dict(zip(one.parameters, given, strict=False)), "nargin": len(given)}
        with suppress(Return):
            self.run(one.block, known)
        return known[one.result]

    def run(self, block: Sequence[Any], known: dict[str, Any]) -> None:
        for kind, *rest in block:
            if kind == "return":
                raise Return
            if kind == "if":
                condition, yes, no = rest
                self.run(yes if self.value(condition, known) else no, known)
                continue
            target, part, value = rest
            if part:
                known[target][part] = self.value(value, known)
            else:
                known[target] = self.value(value, known)

    def value(self, one: Any, known: dict[str, Any]) -> Any:
        kind, *rest = one
        if kind == "number":
            return rest[0]
        if kind == "name":
            assert rest[0] in known, f"{rest[0]} is not defined"
            return known[rest[0]]
        if kind == "field":
            return self.value(rest[0], known)[rest[1]]
        if kind == "call":
            return self.called_value(rest[0], [self.value(inner, known) for inner in rest[1]], known)
        if kind == "matrix":
            return np.array([[self.value(inner, known) for inner in row] for row in rest[0]])
        if kind == "sign":
            return -self.value(rest[1], known) if rest[0] == "-" else self.value(rest[1], known)
        left, right = (self.value(inner, known) for inner in rest)
        if kind in COMPARE:
            return COMPARE[kind](left, right)
        if kind == "\\":
            return np.linalg.solve(left, right)
        return (
            {"+": left + right, "-": left - right, "*": left * right}[kind]
            if kind in "+-*"
            else (left / right if kind == "/" else left**right)
        )

    def called_value(self, what: Any, given: list[Any], known: dict[str, Any]) -> Any:
        kind, *rest = what
        if kind == "name" and rest[0] not in known:
            name = rest[0]
            if name in self.functions:
                return self.call(name, *given)
            assert name in CALLED, f"{name} is neither a variable nor a function that MATLAB has by itself"
            return CALLED[name](*given)
        (k,) = given
        assert k == int(k) >= 1, "indices are whole numbers from one"
        return np.ravel(self.value(what, known))[int(k) - 1]
