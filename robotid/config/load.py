"""A configuration file, checked, with every error at its line."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError
from yaml.nodes import MappingNode

from robotid.config.check import problems
from robotid.config.config_error import config_error
from robotid.config.former_keys import rename_former_keys
from robotid.config.override import override
from robotid.config.schema import Config
from robotid.config.tree import Plain, compose, follow, plain
from robotid.errors import ConfigError

MAX_SIZE = 500_000  # [bytes] of a configuration; ours have ten thousand at most


@dataclass(frozen=True, slots=True)
class Loaded:
    """A configuration that fits together. overrides : what --set changed."""

    config: Config
    path: Path
    overrides: tuple[str, ...] = ()

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


def load(path: Path | str, overrides: Sequence[str] = ()) -> Loaded:
    """Read and check a configuration file. overrides : "key.path=value". Raises ConfigError."""
    path = Path(path)
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
    return Loaded(parse(text, str(path), overrides), path, tuple(overrides))


def _too_large(path: Path) -> ConfigError:
    what = f"larger than {MAX_SIZE // 1000} kB, which no configuration is"
    return ConfigError(what, where=str(path), hint="name measured data under records: file")


def parse(text: str, name: str = "configuration", overrides: Sequence[str] = ()) -> Config:
    """Check a configuration's text and complete it. name : what errors call it. Raises ConfigError."""
    root = compose(text, name)
    if root is None:
        raise ConfigError("this file is empty", where=name, hint="`robotid new NAME` writes one to start from")
    if not isinstance(root, MappingNode):
        raise ConfigError("expected sections such as robot: and records:", where=f"{name}:1")
    rename_former_keys(root)
    for assignment in overrides:
        override(root, assignment)
        rename_former_keys(root)
    try:
        # strict JSON takes a list for a tuple and a word for an enum, and coerces nothing else
        config = Config.model_validate_json(json.dumps(_written(root)), strict=True)
    except ValidationError as error:
        raise config_error(error, root, Config) from error
    for problem in problems(config):
        where, path, _ = follow(root, problem.loc)
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
    return yaml.safe_dump(_dump(config), sort_keys=False, allow_unicode=True, default_flow_style=None, width=120)


def _dump(config: Config) -> dict[str, object]:
    return config.model_dump(mode="json", by_alias=True)
