"""A hard backlash, whose simulation over a whole record no model follows, is named in short pieces."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.paths import CONFIGS

from robotid.artifacts.store import load
from robotid.cli.app import main
from robotid.diagnosis.results import Diagnosis

pytestmark = pytest.mark.slow

GAP = 3e-4  # rad
PLANT = "{motor: [inertia, viscous, coulomb], gear: [spring, cubic_spring, damper, backlash], arm: [inertia]}"


def test_it_is_named_with_its_size(tmp_path: Path) -> None:
    overrides = [f"plant.model={PLANT}", f"plant.parameters.gear.backlash.gap={GAP}"]
    arguments = [argument for one in overrides for argument in ("--set", one)]
    assert main(["run", str(CONFIGS / "paper.yaml"), "--out", str(tmp_path), "--quiet", *arguments]) == 0
    found = load(tmp_path / "diagnosis.h5", Diagnosis).content
    assert isinstance(found, Diagnosis)
    assert [cause.effect for cause in found.causes] == ["gear.backlash"]
    (gap,) = found.causes[0].parameters
    assert abs(gap.value - GAP) < 3.0 * gap.std
    assert found.horizon is not None
    assert found.causes[0].explained > 0.9
