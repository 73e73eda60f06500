"""--set key.path=value: a change to the tree of a configuration, known by its option in errors."""

from __future__ import annotations

import re
from typing import NoReturn

from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from robotid.config.former_keys import current_path
from robotid.config.suggest import suggest
from robotid.config.tree import MAP, NULL, OPTION, STR, compose, join
from robotid.errors import ConfigError
from robotid.model.structure import RECORD_CHANGE

_PARAMETERS = re.compile(r"(robot|plant|robot\.axes\.[^.]+(\.plant)?)\.parameters")


def override(root: MappingNode, assignment: str) -> None:
    """Change the tree in place. A record may be called by its index or its name. Raises ConfigError."""
    path, sign, text = assignment.partition("=")
    words = re.sub(r"\[(\d+)\]", r".\1", path.strip()).split(".")
    name = OPTION + assignment
    if not sign or not all(words):
        raise ConfigError("this sets nothing", where=name, hint="write --set key.path=value")
    value = compose(text, name) or compose("null", name)
    assert value is not None
    _set(root, "", current_path(words), value, name)


def _set(node: Node, path: str, words: list[str], value: Node, name: str) -> None:
    if isinstance(node, MappingNode):
        key, rest = _key(node, path, words)
        old = next((v for k, v in node.value if k.value == key), None)
        new = value if not rest else _open(old, value)
        if rest:
            _set(new, join(path, key), rest, value, name)
        label = ScalarNode(STR, key, value.start_mark, value.end_mark)
        pairs = {k.value: (k, v) for k, v in node.value}
        pairs[key] = (pairs[key][0] if rest and old is new else label, new)
        node.value = list(pairs.values())
    elif isinstance(node, SequenceNode):
        i, rest = _index(node, path, words, name), words[1:]
        if rest:
            _set(node.value[i], f"{path}[{i}]", rest, value, name)
        else:
            node.value[i] = value
    else:
        raise ConfigError(f"{path} is a value, it has no {words[0]}", where=name)


def _open(old: Node | None, value: Node) -> Node:
    """The section to go down into: the old one, or a new one where there was nothing."""
    if old is None or old.tag == NULL:
        return MappingNode(MAP, [], value.start_mark, value.end_mark)
    return old


def _key(node: MappingNode, path: str, words: list[str]) -> tuple[str, list[str]]:
    """The key that the next words spell, and the words left. Parameters have dots in their names."""
    known = {key.value for key, _ in node.value}
    for length in range(len(words), 0, -1):
        if ".".join(words[:length]) in known:
            return ".".join(words[:length]), words[length:]
    dotted = 5 if words[0] == RECORD_CHANGE else 3
    length = dotted if _PARAMETERS.fullmatch(path) else 1
    return ".".join(words[:length]), words[length:]


def _index(node: SequenceNode, path: str, words: list[str], name: str) -> int:
    if words[0].isdigit() and int(words[0]) < len(node.value):
        return int(words[0])
    names = [_name(item) for item in node.value]
    if words[0] in names:
        return names.index(words[0])
    _raise_no_entry(node, path, words[0], [n for n in names if n], name)


def _name(item: Node) -> str:
    pairs = item.value if isinstance(item, MappingNode) else []
    return next((str(value.value) for key, value in pairs if key.value == "name"), "")


def _raise_no_entry(node: SequenceNode, path: str, word: str, names: list[str], name: str) -> NoReturn:
    hint = suggest(word, names) or f"count from 0 to {len(node.value) - 1}"
    raise ConfigError(f'{path} has {len(node.value)} entries and none of them is "{word}"', where=name, hint=hint)
