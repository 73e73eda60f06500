"""A configuration file, checked, with every error at its line."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError
from yaml.nodes import MappingNode

from robotid.config.axes import has_axes, split
from robotid.config.check import problems
from robotid.config.config_error import config_error
from robotid.config.former_keys import rename_former_keys
from robotid.config.override import override
from robotid.config.schema import Config
from robotid.config.suggest import suggest
from robotid.config.tree import Document, Plain, compose, plain
from robotid.errors import ConfigError

MAX_SIZE = 500_000  # [bytes] of a configuration; ours have ten thousand at most


@dataclass(frozen=True, slots=True)
class Loaded:
    """A configuration of one joint that fits together. overrides : what --set changed. axis : which one it is of a
    robot of several, empty for a single joint; robot : the whole configuration of that robot as it is written, without
    defaults."""

    config: Config
    path: Path
    overrides: tuple[str, ...] = ()
    axis: str = ""
    robot: Mapping[str, Any] = field(default_factory=dict, compare=False, repr=False)

    @property
    def directory(self) -> Path:
        """Where the record files are looked for."""
        return self.path.parent

    def resolved_text(self) -> str:
        """The complete configuration, defaults included, as YAML that loads to the same."""
        return resolved(self.config)

    def section_text(self, name: str) -> str:
        """One section with its defaults, the same text whenever it means the same."""
        return json.dumps(_dump(self.config)[name], sort_keys=True)


def load(path: Path | str, overrides: Sequence[str] = (), axis: str | None = None) -> Loaded:
    """Read and check a configuration file of one joint. overrides : "key.path=value". axis : which one of a robot of
    several. Raises ConfigError."""
    found: Loaded = _one_of(load_robot(path, overrides), str(path), axis)
    return found


def load_robot(path: Path | str, overrides: Sequence[str] = ()) -> dict[str, Loaded]:
    """The same of each axis of a robot by its name, "" for a single joint. Raises ConfigError."""
    path = Path(path)
    root = _tree(_text_of(path), str(path), overrides)
    axes, written = _checked_axes(root), _written(root)
    return {
        axis: Loaded(_with_files(config, path.parent), path, tuple(overrides), axis, written)
        for axis, config in axes.items()
    }


def _with_files(config: Config, directory: Path) -> Config:
    """The configuration with the text of the URDF in place of its name. Raises ConfigError."""
    body = config.robot.body
    if body is None or body.urdf is None or body.urdf.lstrip().startswith("<"):
        return config
    path = directory / body.urdf
    try:
        if path.stat().st_size > MAX_SIZE:
            raise ConfigError(f"larger than {MAX_SIZE // 1000} kB, which no URDF is", where=str(path))
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        unreadable = f"cannot be read: {error.strerror}" if isinstance(error, OSError) else "this is not UTF-8 text"
        raise ConfigError(unreadable, where=str(path), hint="check robot.body.urdf") from error
    with_text = body.model_copy(update={"urdf": text})
    return config.model_copy(update={"robot": config.robot.model_copy(update={"body": with_text})})


def _text_of(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(MAX_SIZE + 1)
        text = content.decode("utf-8").replace("\r\n", "\n")
    except FileNotFoundError:
        raise ConfigError("there is no such file", where=str(path), hint="`robotid new NAME` writes one") from None
    except UnicodeDecodeError:
        if len(content) > MAX_SIZE:
            raise _too_large(path) from None
        raise ConfigError("this is not UTF-8 text", where=str(path)) from None
    except OSError as error:
        raise ConfigError(f"cannot be read: {error.strerror}", where=str(path)) from error
    if len(content) > MAX_SIZE:
        raise _too_large(path)
    return text


def _too_large(path: Path) -> ConfigError:
    what = f"larger than {MAX_SIZE // 1000} kB, which no configuration is"
    return ConfigError(what, where=str(path), hint="name measured data under records: file")


def parse(text: str, name: str = "configuration", overrides: Sequence[str] = ()) -> Config:
    """Check the text of a configuration of one joint and complete it. name : what errors call it.

    Raises ConfigError.
    """
    found: Config = _one_of(parse_axes(text, name, overrides), name)
    return found


def parse_axes(text: str, name: str = "configuration", overrides: Sequence[str] = ()) -> dict[str, Config]:
    """The same of each axis by its name, "" for a single joint. Raises ConfigError."""
    return _checked_axes(_tree(text, name, overrides))


def _checked_axes(root: MappingNode) -> dict[str, Config]:
    parts = split(root) if has_axes(root) else {"": Document(root, root)}
    return {axis: _checked(part) for axis, part in parts.items()}


def _one_of(axes: Mapping[str, Any], name: str, axis: str | None = None) -> Any:
    """What is there of an axis, or of a single joint. Raises ConfigError."""
    if "" in axes:
        if axis is not None:
            raise ConfigError("this robot has a single joint", where=name, hint="leave the axis out")
        return axes[""]
    if axis is None:
        raise ConfigError(f"this robot has several axes: {', '.join(axes)}", where=name, hint="choose one with --axis")
    require_axis(axes, axis, name)
    return axes[axis]


def require_axis(axes: Iterable[str], axis: str, where: str) -> None:
    """Raises ConfigError where there is no axis of this name."""
    if axis not in axes:
        raise ConfigError(f'there is no axis "{axis}"', where=where, hint=suggest(axis, axes))


def _tree(text: str, name: str, overrides: Sequence[str]) -> MappingNode:
    """The tree of a configuration, with its current keys and what is set beside it. Raises ConfigError."""
    root = compose(text, name)
    if root is None:
        raise ConfigError("this file is empty", where=name, hint="`robotid new NAME` writes one to start from")
    if not isinstance(root, MappingNode):
        raise ConfigError("expected sections such as robot: and records:", where=f"{name}:1")
    rename_former_keys(root)
    for assignment in overrides:
        override(root, assignment)
        rename_former_keys(root)
    return root


def _checked(tree: Document) -> Config:
    """The configuration of one joint that a tree holds, complete. Raises ConfigError."""
    try:
        # strict JSON takes a list for a tuple and a word for an enum, and coerces nothing else
        config = Config.model_validate_json(json.dumps(_written(tree.root)), strict=True)
    except ValidationError as error:
        raise config_error(error, tree, Config) from error
    for problem in problems(config):
        where, path, _ = tree.follow(problem.loc)
        raise ConfigError(problem.what, where=f"{where}  {path}", hint=problem.hint)
    return config.completed()


def from_plain(sections: Mapping[str, object]) -> Config:
    """Check a configuration that is given as mappings, sequences, words and numbers, those of NumPy as well, and
    complete it. Raises ConfigError."""
    return parse(yaml.safe_dump(_built_in(sections), sort_keys=False))


def _built_in(value: Any) -> Any:
    """A value made of Python's own types alone."""
    if isinstance(value, Mapping):
        return {str(key): _built_in(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_built_in(one) for one in value]
    return value.item() if hasattr(value, "item") else value


def _written(root: MappingNode) -> dict[str, Plain]:
    """The sections; one in which every line is commented out is not there."""
    return {key.value: plain(value) for key, value in root.value if plain(value) is not None}


def resolved(config: Config) -> str:
    """A complete configuration as YAML."""
    return as_yaml(_dump(config))


def as_yaml(sections: Mapping[str, object]) -> str:
    """Sections as YAML."""
    return yaml.safe_dump(dict(sections), sort_keys=False, allow_unicode=True, default_flow_style=None, width=120)


def _dump(config: Config) -> dict[str, object]:
    return config.model_dump(mode="json", by_alias=True)
