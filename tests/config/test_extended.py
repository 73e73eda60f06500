"""The configuration of an extended model."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotid.config.extended import extended_text
from robotid.config.load import load, parse

AXIS = """\
robot: {name: axis, model: {motor: [inertia, coulomb]}}
records:
  - {name: day1, file: day1.csv}
"""


@pytest.mark.parametrize(("given", "kept"), [(None, 0.25), (2.0, 2.0), ("auto", "auto")])
def test_an_extended_configuration_fits_the_pieces_of_the_extension(
    given: float | str | None, kept: float | str, tmp_path: Path
) -> None:
    (tmp_path / "axis.yaml").write_text(AXIS, encoding="utf-8")
    loaded = load(tmp_path / "axis.yaml", [] if given is None else [f"fit.horizon={given}"])
    text = extended_text(loaded, loaded.config.structure(), {}, tmp_path, late=0.0, horizon=0.25)
    assert parse(text).fit.horizon == kept
