"""Keys of earlier versions: a section may still be written with them, and means the same."""

from __future__ import annotations

from collections.abc import Mapping

from yaml.nodes import MappingNode, ScalarNode

from robotid.config.schema import Config
from robotid.config.section import Section
from robotid.config.tree import place
from robotid.errors import ConfigError


def former_keys() -> dict[str, Mapping[str, str]]:
    """By section of the configuration that has former keys, its current keys by the former ones."""
    found = {}
    for name, field in Config.model_fields.items():
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, Section) and kind.former_keys:
            found[field.alias or name] = kind.former_keys
    return found


def rename_former_keys(root: MappingNode) -> None:
    """Rename the former keys in the tree of a configuration, in place; each stays on its line.

    Raises ConfigError where a former key and the current one are both there.
    """
    renamed = former_keys()
    for key, section in root.value:
        if key.value in renamed and isinstance(section, MappingNode):
            section.value = [(_current(k, section, renamed[key.value], key.value), v) for k, v in section.value]


def _current(key: ScalarNode, section: MappingNode, renamed: Mapping[str, str], name: str) -> ScalarNode:
    if key.value not in renamed:
        return key
    current = renamed[key.value]
    if any(other.value == current for other, _ in section.value):
        what = f'"{key.value}" is the former name of {current}, and both are given'
        raise ConfigError(what, where=f"{place(key.start_mark)}  {name}.{key.value}", hint=f"remove {key.value}")
    return ScalarNode(key.tag, current, key.start_mark, key.end_mark)


def current_path(words: list[str]) -> list[str]:
    """A path of --set with its former key, if it has one, renamed."""
    renamed = former_keys().get(words[0], {})
    return [words[0], renamed.get(words[1], words[1]), *words[2:]] if len(words) > 1 else words
