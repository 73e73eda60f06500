"""The manual agrees with the code: what is made from it is fresh, links lead somewhere, words are the field's."""

from __future__ import annotations

import re
import runpy
import tomllib
from pathlib import Path

import pytest
import yaml
from support.manual.checks import severities
from support.manual.pages import FOLDER, README, Page, pages, renewed, replaced
from support.paths import ROOT

from robotid.channels import CHANNELS
from robotid.config.load import parse_axes
from robotid.signals.plausibility import CHECKS
from robotid.terms import TERMS

PAGES = pages()
NAMES = [page.path.name for page in PAGES]
LINK = re.compile(r"\]\(([^)#\s]+)?(?:#([\w-]+))?\)")
FILE = re.compile(r"`((?:configs|data|robotid|tests)/[\w./]+)`")
CITED = re.compile(r"\b([A-Za-z][\w-]*\.md)\b")
DIALECT = re.compile(r"\b(mend(s|ed|ing)?|bent|accused|creeps|borne out|in vain|motives?)\b", re.IGNORECASE)
ABSENT = {"robotid/terms/eddy_brake.py"}  # the example, which a test writes


def anchors(page: Path) -> set[str]:
    """What the headings of a page are called in a link."""
    titles = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_what_is_made_from_the_code_is_up_to_date(page: Page) -> None:
    assert renewed(page.text) == page.text, "run `make docs`"


def test_the_makers_write_into_the_manual() -> None:
    written = "\n".join(page.text for page in PAGES)
    assert all(f"### {effect}\n" in written for effect in (*TERMS, *CHANNELS))
    assert all(f"### {section}\n" in written for section in ("robot", "records[]", "diagnose", "plant.controller"))


def test_every_check_tells_how_grave_it_is() -> None:
    assert [name for name, one in CHECKS.items() if not severities(one)] == []


def test_a_mark_that_is_missing_is_an_error() -> None:
    assert replaced("a <!-- x --> old <!-- end of x --> b", "x", "new").split() == (
        ["a", "<!--", "x", "-->", "new", "<!--", "end", "of", "x", "-->", "b"]
    )
    with pytest.raises(ValueError, match="end of x"):
        replaced("a <!-- x --> old", "x", "new")


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_links_lead_somewhere(page: Page) -> None:
    for target, anchor in LINK.findall(page.text):
        if target.startswith("http"):
            continue
        path = page.path.parent / target if target else page.path
        assert path.exists(), f"{page.path.name} links to {target}"
        assert not anchor or anchor in anchors(path), f"{page.path.name} links to {target}#{anchor}"


def test_every_page_is_listed_in_the_index() -> None:
    listed = {target for target, _ in LINK.findall((FOLDER / "index.md").read_text(encoding="utf-8"))}
    assert {page.name for page in FOLDER.glob("*.md")} == listed | {"index.md"}


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_files_that_are_named_exist(page: Page) -> None:
    assert [name for name in FILE.findall(page.text) if name not in ABSENT and not (ROOT / name).exists()] == []


def test_code_cites_only_pages_of_the_manual() -> None:
    known = {page.name for page in FOLDER.glob("*.md")} | {"README.md", "other.md"}
    sources = [*(ROOT / "robotid").rglob("*.py"), *(ROOT / "tests").rglob("*.py")]
    cited = {(path.name, name) for path in sources for name in CITED.findall(path.read_text(encoding="utf-8"))}
    assert {(path, name) for path, name in cited if name not in known} == set()


def test_every_package_has_its_place_in_the_architecture() -> None:
    packages = {path.name for path in (ROOT / "robotid").iterdir() if path.is_dir() and path.name != "__pycache__"}
    listed = re.findall(r"`robotid/(\w+)`", (FOLDER / "architecture.md").read_text(encoding="utf-8"))
    assert packages == set(listed)


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_the_words_are_those_of_the_field(page: Page) -> None:
    assert DIALECT.findall(page.text) == []


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_configurations_that_are_shown_are_valid(page: Page, tmp_path: Path) -> None:
    for block in page.fenced("yaml"):
        shown = tmp_path / "shown.yaml"
        records = yaml.safe_load(block)["records"]
        for config in parse_axes(block, str(shown)).values():
            assert [record.name for record in config.records] == [record["name"] for record in records]


@pytest.mark.parametrize("script", sorted((ROOT / "data").glob("*.py")), ids=lambda path: path.name)
def test_scripts_beside_the_data_find_what_they_import(script: Path) -> None:
    assert {"main", "__doc__"} <= set(runpy.run_path(str(script), run_name="imported"))


def test_the_readme_is_the_front_page_and_short() -> None:
    assert len(README.read_bytes()) < 9_000
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["readme"] == README.name
