"""A configuration's text as a tree of YAML nodes that remember their lines.

YAML 1.2's core schema: 1e6 is a number, yes and on are words. Keys are text and occur once.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import yaml
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from robotid.errors import ConfigError

Plain = None | bool | int | float | str | list["Plain"] | dict[str, "Plain"]
Step = str | int

OPTION = "--set "
"""How the name of a text begins that comes from the command line: it has no lines."""

_TAG = "tag:yaml.org,2002:"
_SCALARS = {
    "null": r"~|null|Null|NULL|",
    "bool": r"true|True|TRUE|false|False|FALSE",
    "int": r"[-+]?[0-9]+",
    "float": r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
    "merge": r"<<",
}


class _Composer(yaml.SafeLoader):
    """The safe loader with the scalars of YAML 1.2."""

    yaml_implicit_resolvers: dict[str, list[tuple[str, re.Pattern[str]]]] = {}


for _name, _pattern in _SCALARS.items():
    _Composer.add_implicit_resolver(_TAG + _name, re.compile(f"^(?:{_pattern})$"), None)


def compose(text: str, name: str) -> Node | None:
    """The tree of one YAML document, None if it is empty; name : what its marks are called. Raises ConfigError."""
    try:
        loader = _Composer(text)
        loader.name = name
        node = loader.get_single_node()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = name if mark is None or name.startswith(OPTION) else f"{place(mark)}:{mark.column + 1}"
        raise ConfigError(f"this is not YAML: {error.problem or error.context}", where=where) from error
    except yaml.reader.ReaderError as error:
        raise ConfigError("this is not YAML: it holds a character that is not text", where=name) from error
    return None if node is None else _tidy(node, ())


def _tidy(node: Node, above: tuple[Node, ...]) -> Node:
    """A copy in which aliases stand on their own and `<<` is spelled out."""
    if node in above:
        raise ConfigError("an alias stands inside its own anchor", where=place(node.start_mark))
    if node.tag.removeprefix(_TAG) not in {*_SCALARS, "str", "seq", "map"}:
        raise ConfigError(f"YAML tags such as {node.tag} have no meaning here", where=place(node.start_mark))
    above = (*above, node)
    if isinstance(node, SequenceNode):
        return SequenceNode(node.tag, [_tidy(item, above) for item in node.value], node.start_mark, node.end_mark)
    if isinstance(node, MappingNode):
        pairs = [(key, _tidy(value, above)) for key, value in node.value]
        _unique([key for key, _ in pairs])
        return MappingNode(node.tag, _merged(pairs), node.start_mark, node.end_mark)
    return ScalarNode(node.tag, node.value, node.start_mark, node.end_mark)


def _unique(keys: Sequence[Node]) -> None:
    seen: dict[str, Node] = {}
    for key in keys:
        if not isinstance(key, ScalarNode):
            raise ConfigError("a key must be a word", where=place(key.start_mark))
        if key.value in seen and key.value != "<<":
            first = seen[key.value].start_mark.line + 1
            raise ConfigError(f'key "{key.value}" stands twice, first on line {first}', where=place(key.start_mark))
        seen[key.value] = key


def _merged(pairs: list[tuple[ScalarNode, Node]]) -> list[tuple[ScalarNode, Node]]:
    """Pairs of `<<` mappings, behind the mapping's own."""
    own = [(key, value) for key, value in pairs if key.tag != _TAG + "merge"]
    for key, value in pairs:
        if key.tag != _TAG + "merge":
            continue
        for source in value.value if isinstance(value, SequenceNode) else [value]:
            if not isinstance(source, MappingNode):
                raise ConfigError("<< takes a mapping", where=place(key.start_mark))
            known = {k.value for k, _ in own}
            own += [(k, v) for k, v in source.value if k.value not in known]
    return own


def plain(node: Node) -> Plain:
    """The tree as Python's own types."""
    if isinstance(node, MappingNode):
        return {key.value: plain(value) for key, value in node.value}
    if isinstance(node, SequenceNode):
        return [plain(item) for item in node.value]
    text: str = node.value
    match node.tag.removeprefix(_TAG):
        case "null":
            return None
        case "bool":
            return text.lower() == "true"
        case "int":
            return int(text)
        case "float":
            return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))
    return text


def place(mark: yaml.Mark) -> str:
    """File and line of a mark, or the option that it comes from."""
    return mark.name if mark.name.startswith(OPTION) else f"{mark.name}:{mark.line + 1}"


def follow(root: Node, steps: Sequence[Step]) -> tuple[str, str, Node]:
    """Place, dotted path and node of the steps, as far as the text goes. Steps that are not in it are passed over."""
    node, mark, path = root, root.start_mark, ""
    for step in steps:
        if isinstance(node, SequenceNode) and isinstance(step, int) and step < len(node.value):
            node = node.value[step]
            mark, path = node.start_mark, f"{path}[{step}]"
        elif isinstance(node, MappingNode):
            for key, value in node.value:
                if key.value == step:
                    node, mark, path = value, key.start_mark, join(path, str(step))
                    break
    return place(mark), path, node


def join(path: str, key: str) -> str:
    """A dotted path, one key longer."""
    return f"{path}.{key}" if path else key
