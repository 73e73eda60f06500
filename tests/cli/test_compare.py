"""`compare`: runs side by side."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from support.html_document import Document

from robotid.artifacts.store import load
from robotid.cli.app import main
from robotid.estimate.result import Fits


@pytest.fixture
def two_runs(run_directory: Path, tmp_path: Path) -> tuple[str, str]:
    """The same run twice: whatever differs, differs by nothing."""
    copy = tmp_path / "friday"
    shutil.copytree(run_directory, copy)
    return str(run_directory), str(copy)


def test_a_run_does_not_differ_from_its_copy(two_runs: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", *two_runs, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["reference"] == Path(two_runs[0]).name
    assert [one["difference"] for one in found["differences"]] == [0.0] * len(found["differences"])
    assert not any(one["differs"] for one in found["differences"])
    assert "their errors are not independent" in found["remarks"][0]
    fit = load(Path(two_runs[1]) / "model.h5", Fits).content.models["m"]
    assert found["runs"]["friday"]["parameters"]["gear.spring.k1"]["value"] == fit["gear.spring.k1"].value
    assert found["runs"]["friday"]["verdict"] in ("clean", None)


def test_a_page_of_it(two_runs: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "c.html"
    assert main(["compare", *two_runs, "--page", str(page)]) == 0
    shown = capsys.readouterr()
    assert "no parameter differs significantly from" in shown.err
    assert f"{page} written" in shown.err
    assert "gear.spring.k1" in shown.out
    text = page.read_text()
    assert text.count("<svg") == 1
    assert 'class="wide"' in text  # intervals in two columns
    assert "No parameter differs significantly" in text
    assert "The whole configuration" not in text
    Document(text)


def test_what_cannot_be_compared_is_refused(
    two_runs: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["compare", two_runs[0]]) == 2
    assert main(["compare", two_runs[0], two_runs[0]]) == 2
    assert main(["compare", two_runs[0], str(tmp_path / "none")]) == 3
    (tmp_path / "model.h5").write_bytes(b"")
    assert main(["compare", two_runs[0], str(tmp_path / "model.h5")]) == 3
    assert main(["compare", *two_runs, "--model", "no"]) == 2
    complaints = capsys.readouterr().err
    for text in (
        "nothing to compare with",
        "given twice",
        "no such run directory",
        "it is a file",
        'there is no model "no"',
    ):
        assert text in complaints
