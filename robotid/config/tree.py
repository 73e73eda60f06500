"""A configuration's text as a tree of YAML nodes that remember their lines.

YAML 1.2's core schema: 1e6 is a number, yes and on are words. Keys are text and occur once.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import yaml
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from robotid.errors import ConfigError, printable

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

_KINDS = {kind: _TAG + kind for kind in ("str", "seq", "map")}
FLOAT, MAP, NULL, SEQ, STR = (_TAG + kind for kind in ("float", "map", "null", "seq", "str"))

MAX_NODES = 50_000  # of a configuration, aliases counted as often as they stand
MAX_DEPTH = 40  # of sections in each other; the deepest of ours is at 9
MAX_DIGITS = 400  # of a number


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
    except RecursionError:
        raise ConfigError(f"sections stand deeper than {MAX_DEPTH} in each other", where=name) from None
    except (ValueError, OverflowError) as error:  # an escape beyond Unicode, a version of many digits
        raise ConfigError("this is not YAML: an escape or number that means nothing", where=name) from error
    return None if node is None else _Tidying().tidy(node, ())


class _Tidying:
    """Makes a copy of a tree in which aliases stand on their own and `<<` is spelled out: a tree of bounded size, for a
    few aliases of aliases are worth thousands of millions of nodes."""

    def __init__(self) -> None:
        self.nodes = 0

    def tidy(self, node: Node, above: tuple[Node, ...]) -> Node:
        """The copy of a node below others. Raises ConfigError."""
        self.nodes += 1
        if any(node is other for other in above):
            raise ConfigError("an alias stands inside its own anchor", where=place(node.start_mark))
        if self.nodes > MAX_NODES:
            what = f"the configuration has more than {MAX_NODES} entries"
            raise ConfigError(what, where=place(node.start_mark), hint="write fewer aliases")
        if len(above) >= MAX_DEPTH:
            what = f"sections stand deeper than {MAX_DEPTH} in each other"
            raise ConfigError(what, where=place(node.start_mark))
        if node.tag.removeprefix(_TAG) not in {*_SCALARS, *_KINDS}:
            raise ConfigError(f"YAML tags such as {node.tag} have no meaning here", where=place(node.start_mark))
        above = (*above, node)
        if isinstance(node, SequenceNode):
            items = [self.tidy(item, above) for item in node.value]
            return SequenceNode(_KINDS["seq"], items, node.start_mark, node.end_mark)
        if isinstance(node, MappingNode):
            pairs = [(_word(key), self.tidy(value, above)) for key, value in node.value]
            _unique([key for key, _ in pairs])
            return MappingNode(_KINDS["map"], self._merged(pairs), node.start_mark, node.end_mark)
        return _scalar(node)

    def _merged(self, pairs: list[tuple[ScalarNode, Node]]) -> list[tuple[ScalarNode, Node]]:
        """Pairs of `<<` mappings, behind the mapping's own."""
        own = [(key, value) for key, value in pairs if key.tag != _TAG + "merge"]
        known = {key.value for key, _ in own}
        for key, value in pairs:
            if key.tag != _TAG + "merge":
                continue
            for source in value.value if isinstance(value, SequenceNode) else [value]:
                if not isinstance(source, MappingNode):
                    raise ConfigError("<< takes a mapping", where=place(key.start_mark))
                added = [(k, v) for k, v in source.value if k.value not in known]
                own += added
                known |= {k.value for k, _ in added}
        return own


def _word(key: Node) -> ScalarNode:
    """The key of a mapping."""
    if not isinstance(key, ScalarNode):
        raise ConfigError("a key must be a word", where=place(key.start_mark))
    return _scalar(key)


def _scalar(node: Node) -> ScalarNode:
    """A scalar that means what its tag says. Raises ConfigError."""
    kind, text, where = node.tag.removeprefix(_TAG), node.value, place(node.start_mark)
    if printable(text, keep="\n\t\u0085\ufeff") != text:
        raise ConfigError("a control character stands in the text", where=where, hint="remove it")
    if kind in ("seq", "map") or (kind in _SCALARS and not re.fullmatch(_SCALARS[kind], text)):
        raise ConfigError(f'"{text[:MAX_DIGITS]}" is no !!{kind}', where=where)
    if kind in ("int", "float") and len(text) > MAX_DIGITS:
        raise ConfigError(f"a number of {len(text)} digits", where=where, hint=f"write {MAX_DIGITS} at most")
    return ScalarNode(node.tag, text, node.start_mark, node.end_mark)


def _unique(keys: Sequence[ScalarNode]) -> None:
    seen: dict[str, Node] = {}
    for key in keys:
        if key.value in seen and key.value != "<<":
            first = seen[key.value].start_mark.line + 1
            raise ConfigError(f'key "{key.value}" stands twice, first on line {first}', where=place(key.start_mark))
        seen[key.value] = key


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


def path_to(tree: Node, sought: Node, path: str = "") -> str:
    """The dotted path of a node, empty where it is not in the tree."""
    if tree is sought:
        return path
    if isinstance(tree, MappingNode):
        inner = [(join(path, key.value), value) for key, value in tree.value]
    elif isinstance(tree, SequenceNode):
        inner = [(f"{path}[{k}]", value) for k, value in enumerate(tree.value)]
    else:
        return ""
    return next((found for name, value in inner if (found := path_to(value, sought, name))), "")


@dataclass(frozen=True, slots=True, eq=False)
class Document:
    """A tree whose parts may stand in another one, that of the text. made : nodes that are in neither the text nor
    another of them, with the path in the text of what they are made of."""

    root: MappingNode
    text: MappingNode
    made: tuple[tuple[Node, str], ...] = ()

    def follow(self, steps: Sequence[Step]) -> tuple[str, str, Node]:
        """Place and dotted path in the text, and the node, of the steps as far as the tree goes."""
        where, path, node = follow(self.root, steps)
        if self.root is self.text:
            return where, path, node
        origin = next((origin for one, origin in self.made if one is node), "")
        return where, origin or path_to(self.text, node) or path, node
