"""What each stage made, as tables for people and JSON for scripts. A stage without a file here has a generic view."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from types import ModuleType


def view(stage: str) -> ModuleType:
    """The module with `tables(content)` and `document(content)` for a stage's content."""
    name = f"{__name__}.{stage.replace('-', '_')}"
    return import_module(name if find_spec(name) else f"{__name__}.generic")
