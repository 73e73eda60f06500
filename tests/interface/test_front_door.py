"""`import robotid` offers its names and loads next to nothing."""

from __future__ import annotations

import ast
import importlib
import inspect
import json
import subprocess
import sys
from pathlib import Path

import pytest
from support.paths import ROOT

import robotid

HEAVY = {"numpy", "scipy", "h5py", "pydantic", "yaml", "matplotlib", "pandas", "rich", "typer"}
SCRIPT = """
import json, sys
import robotid
modules = sorted({name.partition(".")[0] for name in sys.modules})
print(json.dumps([modules, [name for name in sys.modules if name.startswith("robotid")], dir(robotid)]))
"""
NAMES = [name for name in robotid.__all__ if name != "__version__"]
FUNCTIONS = [
    "read",
    "fit",
    "simulate",
    "validate",
    "diagnose",
    "extend",
    "compare",
    "watch",
    "state_space",
    "load",
    "save",
    "explain",
]


@pytest.fixture(scope="module")
def imported() -> list[list[str]]:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    found: list[list[str]] = json.loads(done.stdout)
    return found


def test_importing_the_package_loads_nothing_else(imported: list[list[str]]) -> None:
    assert HEAVY & set(imported[0]) == set()
    assert set(imported[1]) == {"robotid", "robotid.lazy"}


def test_all_names_are_offered_before_they_are_loaded(imported: list[list[str]]) -> None:
    assert set(robotid.__all__) == set(imported[2])
    assert set(FUNCTIONS) < set(robotid.__all__)


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_what_its_home_defines(name: str) -> None:
    home = importlib.import_module(f"robotid.{robotid._HOMES[name]}")
    assert getattr(robotid, name) is getattr(home, name)
    assert getattr(robotid, name).__module__ == home.__name__


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_is_documented_in_whole_sentences(name: str) -> None:
    text = inspect.getdoc(getattr(robotid, name)) or ""
    assert text[:1].isupper()
    assert "." in text


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_tells_its_errors_and_has_an_example(name: str) -> None:
    text = inspect.getdoc(getattr(robotid, name)) or ""
    assert "Raises" in text
    assert ">>> " in text


def test_tools_that_read_types_see_every_name() -> None:
    tree = ast.parse(Path(robotid.__file__).read_text(encoding="utf-8"))
    checked = next(n for n in tree.body if isinstance(n, ast.If) and ast.unparse(n.test) == "TYPE_CHECKING")
    imports = {
        alias.asname: node.module for node in checked.body if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    assert imports == {name: f"robotid.{home}" for name, home in robotid._HOMES.items()}


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match=r"robotid.*'diagnos'"):
        robotid.diagnos  # noqa: B018


def test_no_room_hides_a_public_name() -> None:
    rooms = {path.stem for path in (ROOT / "robotid").iterdir()}
    assert rooms & set(NAMES) == set()


def test_the_package_is_typed() -> None:
    assert (ROOT / "robotid" / "py.typed").is_file()
