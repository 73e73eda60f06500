"""Diagnosis of an axis of a real robot while all others move: what is not there is not named."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import pytest
from support.paths import ROOT

from robotid.artifacts.store import load
from robotid.cli.app import main
from robotid.diagnosis.results import Diagnosis

KUKA = ROOT.parent / "shared" / "data" / "kuka_kr300"
pytestmark = pytest.mark.slow


@cache
def diagnosis() -> Diagnosis:
    """Of axis 1, whose inertia follows the pose of the axes beyond it, by a model that knows nothing of them."""
    if not KUKA.is_dir():
        pytest.skip("the measured records kuka_kr300 are third-party data and not here")
    folder = Path(mkdtemp())
    config = str(ROOT / "configs" / "kuka_axis1.yaml")
    assert main(["run", config, "--out", str(folder), "--quiet"]) == 0
    found = load(folder / "diagnosis.h5", Diagnosis).content
    assert isinstance(found, Diagnosis)
    return found


def test_no_gearbox_warms_up_in_a_second() -> None:
    assert not [c.effect for c in diagnosis().causes if c.effect.endswith("thermal_friction")]


def test_the_pose_of_the_arm_is_named_and_carries_over() -> None:
    assert diagnosis().causes[0].effect == "arm.pose_lever[q2]"
    assert diagnosis().causes[0].heldout_gain > 14.0


def test_shares_and_what_remains_make_one() -> None:
    shares = sum(c.explained for c in diagnosis().causes if not c.explained_of)
    assert shares + diagnosis().remaining_share == pytest.approx(1.0, abs=1e-9)
