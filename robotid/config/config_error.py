"""What the schema found wrong, as one line for a person."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from robotid.config.suggest import suggest
from robotid.config.tree import Document, Step
from robotid.errors import ConfigError

_KINDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text",
    "bool_type": "true or false",
    "tuple_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
}
_LIMITS = {
    "greater_than": ("gt", "greater than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}


def config_error(error: ValidationError, tree: Document, schema: type[BaseModel]) -> ConfigError:
    """The first thing to correct: an unknown key rather than the key that is missing for it, then by line."""
    return _one(min(error.errors(), key=lambda detail: _rank(detail, tree)), tree, schema)


def _rank(detail: ErrorDetails, tree: Document) -> tuple[int, int, int]:
    """Smaller is more urgent."""
    line, kind = tree.follow(detail["loc"])[2].start_mark.line, detail["type"]
    if kind == "too_short":  # a list also counts as too short when its entries are wrong
        return 2, -len(detail["loc"]), line
    if kind == "string_type" and isinstance(detail["input"], dict | list | tuple):
        return 3, 0, line  # a word would do as well, but more than a word was meant
    return int(kind != "extra_forbidden"), 0, line


def _one(detail: ErrorDetails, tree: Document, schema: type[BaseModel]) -> ConfigError:
    loc = detail["loc"]
    where, path, _ = tree.follow(loc)
    what, hint = _message(detail["type"], detail["input"], detail.get("ctx", {}), detail["msg"], loc)
    if detail["type"] == "extra_forbidden":
        hint = suggest(str(loc[-1]), keys_at(schema, loc[:-1]))
    return ConfigError(what, where=f"{where}  {path}".rstrip(), hint=hint)


def _message(kind: str, found: Any, context: Mapping[str, Any], message: str, loc: Sequence[Step]) -> tuple[str, str]:
    """What is wrong, and a hint."""
    last = loc[-1] if loc else ""
    match kind:
        case "extra_forbidden":
            return f'there is no key "{last}"', ""
        case "missing":
            return (f"entry {last} is missing" if isinstance(last, int) else f'"{last}" is missing'), ""
        case "union_tag_not_found":
            return f"{context['discriminator']} is missing".replace("'", '"'), ""
        case "union_tag_invalid":
            return _choice(str(context["tag"]), str(context["expected_tags"]))
        case "literal_error" | "enum":
            return _choice(found, str(context["expected"]))
        case "value_error":
            return str(context["error"]), ""
        case "too_short" | "too_long":
            count = f"at least {context['min_length']}" if kind == "too_short" else f"at most {context['max_length']}"
            return f"expected {count} {'entry' if count.endswith(' 1') else 'entries'}, found {len(found)}", ""
        case "finite_number":
            return f"expected a finite number, found {_show(found)}", ""
        case "string_pattern_mismatch":
            return f"a name has letters, digits, _ and - only, found {_show(found)}", ""
    if kind in _KINDS:
        return f"expected {_KINDS[kind]}, found {_show(found)}", _fraction(found)
    if kind in _LIMITS:
        symbol, words = _LIMITS[kind]
        return f"must be {words} {context[symbol]:g}, found {_show(found)}", ""
    return f"{message}, found {_show(found)}", ""


def _choice(found: Any, expected: str) -> tuple[str, str]:
    return f"{_show(found)} is not a choice", suggest(str(found), re.findall(r"'([^']*)'", expected))


def _fraction(found: Any) -> str:
    """A hint to who wrote a gear ratio as 1/224.3."""
    match = re.fullmatch(r"([0-9.]+) */ *([0-9.]*[1-9][0-9.]*)", found) if isinstance(found, str) else None
    try:
        return f"did you mean {float(match[1]) / float(match[2]):.8g}?" if match else ""
    except ValueError:
        return ""


def _show(found: Any) -> str:
    if isinstance(found, dict):
        return "a mapping"
    if isinstance(found, list | tuple):
        return "a list"
    return "nothing" if found is None else json.dumps(found, ensure_ascii=False)


def keys_at(schema: Any, loc: Sequence[Step]) -> list[str]:
    """The keys that the schema knows where loc leads.

    An index, a mapping's key and a union's tag are steps too, of which only the tag narrows what may come.
    """
    kinds = [schema]
    for step in loc:
        inside = [inner for kind in kinds for inner in _enter(kind, step)]
        kinds = inside or [kind for kind in kinds if _tagged(kind, step)] or kinds
    return [field.alias or name for kind in kinds for name, field in kind.model_fields.items()]


def _enter(kind: type[BaseModel], step: Step) -> Iterator[type[BaseModel]]:
    for name, field in kind.model_fields.items():
        if step in (name, field.alias):
            yield from _sections(field.annotation)


def _sections(annotation: Any) -> Iterator[type[BaseModel]]:
    """The sections that an annotation leads to, through unions, lists and mappings."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _sections(inner)


def _tagged(kind: type[BaseModel], tag: Step) -> bool:
    return kind.__name__ == tag or any(tag in get_args(field.annotation) for field in kind.model_fields.values())
