"""`show --plot`: the figures of a run, the paper's Figures 2 and 3 among them."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotid.cli.app import main


@pytest.mark.parametrize(
    "artifact", ["excitation.h5", "records.h5", "rigid.h5", "flex.h5", "model.h5", "validation.h5"]
)
@pytest.mark.parametrize("suffix", [".png", ".pdf"])
def test_draws_whole_files(artifact: str, suffix: str, run_directory: Path, tmp_path: Path) -> None:
    figure = tmp_path / f"figure{suffix}"
    assert main(["show", str(run_directory / artifact), "--plot", str(figure)]) == 0
    assert figure.read_bytes()[:4] == {".png": b"\x89PNG", ".pdf": b"%PDF"}[suffix]
    assert [file.name for file in tmp_path.glob("*.p[dn]*")] == [figure.name]


@pytest.mark.parametrize(
    ("artifact", "name", "line"),
    [
        ("flex.h5", "figure.doc", 'no figure can be written as "doc"; use png, svg, pdf'),
    ],
)
def test_what_cannot_be_drawn_is_said(
    artifact: str, name: str, line: str, run_directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["show", str(run_directory / artifact), "--plot", str(tmp_path / name)]) == 2
    assert line in capsys.readouterr().err
    assert not list(tmp_path.glob("*figure*"))
