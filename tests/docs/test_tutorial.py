"""The tutorial followed block by block: its code runs, and prints what the page shows."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from support.manual.pages import FENCE, FOLDER, Page
from support.paths import ROOT

PAGE = Page(FOLDER / "tutorial.md")
NUMBER = re.compile(r"-?\d+\.\d+")
NEAR = 0.1  # of a number that is shown: fits are in %, and the page promises no more digits than that


def blocks() -> Iterator[tuple[str, str]]:
    """Every block of code, and the text that is shown below it, empty where there is none."""
    found = FENCE.findall(PAGE.text)
    for (kind, code), (below, text) in zip(found, [*found[1:], ("", "")], strict=True):
        if kind == "python":
            yield code, text if below == "text" else ""


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[str, str]]:
    """What every block prints, in one namespace and in one folder, and what the page shows."""
    folder = tmp_path_factory.mktemp("tutorial")
    for log in ("log.csv", "day2.csv"):
        shutil.copy(ROOT / "data" / log, folder)
    names: dict[str, Any] = {}
    found = []
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for code, shown in blocks():
            out = StringIO()
            with redirect_stdout(out):
                exec(code, names)
            found.append((out.getvalue(), shown))
        assert Path("gain.png").read_bytes().startswith(b"\x89PNG")
    return found


def test_the_way_from_log_to_gain_takes_twelve_lines() -> None:
    first, _ = next(blocks())
    assert len([line for line in first.splitlines() if line.strip()]) <= 12


def near(line: str, shown: str) -> bool:
    """Whether two lines have the same words, and numbers that are close."""
    numbers, told = (list(map(float, NUMBER.findall(text))) for text in (line, shown))
    return NUMBER.sub("#", line) == NUMBER.sub("#", shown) and numbers == pytest.approx(told, abs=NEAR)


def test_the_code_prints_what_the_page_shows(printed: list[tuple[str, str]]) -> None:
    promised = [(out.splitlines(), line) for out, shown in printed for line in shown.splitlines()]
    assert len(promised) == 9
    assert [shown for lines, shown in promised if not any(near(line, shown) for line in lines)] == []


def test_blocks_without_an_output_on_the_page_show_something(printed: list[tuple[str, str]]) -> None:
    assert all(out for out, _ in printed)
