"""The effects of a folder: every file is one, so a new file is known at once and there is no list to keep."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any


def discover(package: str, path: Iterable[str], family: type) -> dict[str, Any]:
    """One instance of the effect in each file of a package, by name, in alphabetical order.

    path : folders of the package (its __path__); family : Term or Channel. Raises TypeError where a file does not
    hold exactly one effect of its own name.
    """
    names = sorted(module.name for module in iter_modules(path))
    return {name: _effect(import_module(f"{package}.{name}"), name, family)() for name in names}


def _effect(module: ModuleType, name: str, family: type) -> Any:
    own = [c for c in vars(module).values() if isinstance(c, type) and c.__module__ == module.__name__]
    effects = [c for c in own if issubclass(c, family)]
    if [getattr(c, "name", None) for c in effects] != [name]:
        found = ", ".join(c.__name__ for c in effects) or "none"
        raise TypeError(f'{module.__file__} must define one {family.__name__} with name = "{name}"; it defines {found}')
    return effects[0]
