"""The body of an industrial robot: identified on one motion, it predicts the torques of another."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support.paths import ROOT

from robotid.body.results import BodyResult
from robotid.config.load import load
from robotid.signals.quality import Recordings
from robotid.signals.readers import read
from robotid.stages.collect import collect

CONFIG = ROOT / "configs" / "kuka_robot.yaml"
FOLDER = ROOT / ".." / "shared" / "data" / "kuka_kr300"

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"the measured records are not in {FOLDER}")


@cache
def recordings(*fitted: str, axis: str = "a1") -> Recordings:
    """The records of an axis, the body identified on some of them."""
    config = load(CONFIG, axis=axis).config
    roles = {name: "estimate" if name in fitted else "validate" for name in ("A", "B")}
    records = tuple(r.model_copy(update={"role": roles[r.name]}) for r in config.records)
    chosen = config.model_copy(update={"records": records})
    return collect(chosen, None, {r.name: read(CONFIG.parent / r.files[0]) for r in records})


def body(*fitted: str) -> BodyResult:
    found = recordings(*fitted).body
    assert found is not None
    return found


def test_a_motion_predicts_the_torques_of_another() -> None:
    """Least squares of the base parameters alone predicts axis 1 to 90 % and axis 4 to 170 %."""
    held_out = next(e for e in body("A").errors if e.record == "B")
    assert np.all(np.array(held_out.consistent) < [20.0, 24.0, 13.0, 35.0, 20.0, 30.0])
    assert max(held_out.base) > 100.0


def test_both_motions_are_explained_by_one_body() -> None:
    errors = np.array([e.consistent for e in body("A", "B").errors])
    assert np.all(np.sqrt(np.mean(errors**2, axis=0)) < [15.0, 17.0, 10.0, 30.0, 12.0, 22.0])


def test_the_inertia_of_the_vertical_axis_is_that_of_the_maker() -> None:
    """The model that comes with the files has other masses, and nearly the same inertia about the vertical."""
    found = recordings("A")
    for record in found.records:
        table = read(FOLDER / f"{record.name}.mat")
        maker = np.asarray(table.columns["m_all"])
        maker = maker[0] if maker.shape[0] == 6 else maker[:, 0]
        ours = record.companions["body_inertia"].values
        assert np.corrcoef(ours, maker)[0, 1] > 0.98
        assert np.ptp(ours) == pytest.approx(np.ptp(maker), rel=0.25)


def test_what_ten_seconds_do_not_show_is_stated() -> None:
    remarks = " ".join(body("A").remarks)
    assert "base parameters are not distinct from zero" in remarks
    assert "keep near their start" in remarks
