"""Every section and key of the configuration for the manual, with kinds and defaults, from the schema itself."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import yaml

from robotid.config.schema import Config
from robotid.config.section import Section
from support.manual.markdown import table

Schema = dict[str, Any]
LIMITS = {"exclusiveMinimum": "above", "minimum": "at least", "exclusiveMaximum": "below", "maximum": "at most"}
EXPLAINED = re.compile(
    r"(?:^|(?<=[.;:])|(?<=[.;:]\s))\s*(?P<keys>\w+(?:,\s+\w+)*)(?:\s+\[(?P<unit>[^\]]+)\])?\s:\s", re.MULTILINE
)
KINDS = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false"}


def sections() -> str:
    """A heading, a description and a table of keys for every mapping that a configuration may hold."""
    schema = Config.model_json_schema(mode="validation")
    places: dict[str, list[str]] = {}
    _visit(schema, schema, "", places)
    return "\n\n".join(_section(schema, schema["$defs"][name], paths) for name, paths in places.items())


def _visit(whole: Schema, schema: Schema, path: str, places: dict[str, list[str]]) -> None:
    """Collect where each kind of mapping stands, in the order of the schema."""
    for key, value in schema["properties"].items():
        for name, where in _mappings(whole, value, f"{path}.{key}".lstrip(".")):
            places.setdefault(name, []).append(where)
            if len(places[name]) == 1:
                _visit(whole, whole["$defs"][name], where, places)


def _section(whole: Schema, schema: Schema, paths: list[str]) -> str:
    required = schema.get("required", ())
    keys = set(schema["properties"])
    prose, meanings = _meanings(schema.get("description", ""), keys)
    for base in _bases(schema["title"]):
        meanings = _meanings(base, keys)[1] | meanings
    rows = [
        (f"`{key}`", _kind(whole, value), _default(whole, value, needed=key in required), meanings.get(key, ""))
        for key, value in schema["properties"].items()
    ]
    head = ("key", "value", "default", "meaning") if meanings else ("key", "value", "default")
    also = f"The same keys stand at {', '.join(f'`{path}`' for path in paths[1:])}."
    parts = (f"### {paths[0]}", _prose(prose), also if len(paths) > 1 else "")
    return "\n\n".join([*filter(None, parts), table(head, [row[: len(head)] for row in rows])])


def _bases(name: str) -> list[str]:
    """What the docstrings of the sections say that the one of this name builds on."""
    left, known = [Section], dict[str, type[Section]]()
    while left:
        section = left.pop()
        known[section.__name__] = section
        left += section.__subclasses__()
    bases = [base for base in known[name].__mro__[1:] if issubclass(base, Section) and base is not Section]
    return [inspect.cleandoc(base.__doc__ or "") for base in bases]


def _meanings(text: str, keys: set[str]) -> tuple[str, dict[str, str]]:
    """A docstring taken apart: what is on the whole section, and what on each key, as `key [unit] : meaning`."""
    found = [m for m in EXPLAINED.finditer(text) if set(_keys(m)) <= keys]
    meanings = {}
    ends = [*(following.start() for following in found[1:]), len(text)][: len(found)]
    for this, end in zip(found, ends, strict=True):
        words = " ".join(text[this.end() : end].split()).strip(" .;")
        unit = f" [{this['unit']}]" if this["unit"] else ""
        meanings |= {key: f"{words}{unit}".replace("*", "\\*") for key in _keys(this)}
    return text[: found[0].start()] if found else text, meanings


def _keys(found: re.Match[str]) -> list[str]:
    return re.split(r",\s+", found["keys"])


def _mappings(whole: Schema, value: Schema, path: str) -> Iterator[tuple[str, str]]:
    """The kinds of mappings inside a value, and where they stand."""
    if "$ref" in value:
        target = _target(whole, value)
        if "properties" in target:
            kind = target["properties"].get("kind", {}).get("const")
            yield value["$ref"].rpartition("/")[2], f"{path} ({kind})" if kind else path
    for part in (*value.get("anyOf", ()), *value.get("oneOf", ())):
        yield from _mappings(whole, part, path)
    if "items" in value:
        yield from _mappings(whole, value["items"], f"{path}[]")
    yield from (found for part in _named(value) for found in _mappings(whole, part, f"{path}.NAME"))


def _named(value: Schema) -> list[Schema]:
    """What the entries of a mapping with free names may be."""
    free = value.get("additionalProperties")
    return [*value.get("patternProperties", {}).values(), *([free] if isinstance(free, dict) else [])]


def _target(whole: Schema, value: Schema) -> Schema:
    found: Schema = whole["$defs"][value["$ref"].rpartition("/")[2]]
    return found


def _prose(text: str) -> str:
    """A docstring as Markdown: paragraphs, with what stands on a line of its own as a list."""
    paragraphs = [" ".join(part.split()) for part in re.split(r"\n\s*\n", text)]
    return "\n\n".join(part.replace("|", "\\|").replace("*", "\\*") for part in paragraphs)


def _kind(whole: Schema, value: Schema) -> str:
    """What a value may be, in words."""
    if "$ref" in value:
        target = _target(whole, value)
        return "mapping" if "properties" in target else _kind(whole, target)
    if "anyOf" in value or "oneOf" in value:
        parts = [_kind(whole, part) for part in (*value.get("anyOf", ()), *value.get("oneOf", ()))]
        return " or ".join(dict.fromkeys(parts))
    if "enum" in value:
        return " or ".join(f"`{one}`" for one in value["enum"])
    if "const" in value:
        return f"`{value['const']}`"
    match value.get("type"):
        case "array":
            inner = [_kind(whole, part) for part in value.get("prefixItems", ())]
            if inner:
                return f"[{', '.join(inner)}]"
            return f"list of {_kind(whole, value['items'])}"
        case "object":
            named = [_kind(whole, part) for part in _named(value)]
            return f"mapping of names to: {named[0]}" if named else "mapping"
        case "null":
            return "null"
        case other:
            limits = [f"{word} {value[key]:g}" for key, word in LIMITS.items() if key in value]
            return " ".join([KINDS.get(str(other), str(other)), *limits])


def _default(whole: Schema, value: Schema, *, needed: bool) -> str:
    if needed:
        return "must be given"
    if "const" in value:
        return "must be given"
    if "default" not in value:
        return "-"
    default = value["default"]
    if isinstance(default, dict) and default and any(_mappings(whole, value, "")):
        return "as below"
    return f"`{yaml.safe_dump(default, default_flow_style=True).removesuffix('...' + chr(10)).strip()}`"
