"""Stage validate: every model on every record, and what the configuration demands."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from support.judged_records import clean_records, clean_responses
from support.paper_joint import RATIO, TRUTH

from robotid.artifacts import codec
from robotid.config.schema import Config
from robotid.estimate.flexible import FlexResult
from robotid.estimate.result import Fits
from robotid.estimate.rigid import RigidResult
from robotid.signals.quality import Recordings
from robotid.stages.fit import fit
from robotid.stages.validate import validate
from robotid.validation.results import Validation

START = TRUTH | {"gear.spring.k1": 1.2e6, "motor.coulomb.Fc": 0.6}
NOTHING = RigidResult((), np.zeros((0, 0)), 1.0, {}, {}, START, ())


def config(**sections: Any) -> Config:
    model = {
        "motor": ("inertia", "viscous", "coulomb"),
        "gear": ("spring", "cubic_spring", "damper"),
        "arm": ("inertia",),
    }
    records = tuple({"name": r.name, "file": f"{r.name}.csv", "role": r.role} for r in clean_records())
    sections = {"fit": {"models": {"m1": ("small",), "m2": ("small",)}, "best": "m1"}} | sections
    robot = {"name": "irb", "gear_ratio": RATIO, "model": model}
    return Config.model_validate({"robot": robot, "records": records, **sections}).completed()


def recordings() -> Recordings:
    return Recordings(records=clean_records(), reports=())


def flex() -> FlexResult:
    return FlexResult(clean_responses(), (), (), (), {}, ())


@cache
def fits() -> Fits:
    return fit(config(), recordings(), NOTHING, flex())


@cache
def validation() -> Validation:
    loop = {"kind": "speed", "kp": 0.5, "ki": 5.0}
    return validate(config(controller=loop), recordings(), NOTHING, flex(), fits())


def test_every_model_on_every_record_the_initial_one_first() -> None:
    assert list(validation().models) == ["m0", "m1", "m2"]
    for model in validation().models.values():
        assert list(model.records) == ["small", "large"]
        assert all(record.closed_loop is not None for record in model.records.values())
        assert model.bode is not None
    assert [r.used for r in validation().models["m1"].records.values()] == [True, False]
    assert [r.used for r in validation().models["m0"].records.values()] == [False, False]


def test_fits_of_the_start_and_of_the_truth() -> None:
    assert validation().models["m0"].records["large"].fit_percent < 90
    assert validation().models["m1"].records["large"].fit_percent == pytest.approx(100, abs=0.01)
    values = dict(zip(validation().models["m0"].names, validation().models["m0"].values, strict=True))
    assert values == pytest.approx(START)


def test_the_best_model_alone_is_perturbed() -> None:
    tables = {name: model.records["small"].perturbation for name, model in validation().models.items()}
    assert tables["m1"].names == validation().models["m1"].names
    assert tables["m1"].percent == 20.0
    assert tables["m0"].names == tables["m2"].names == ()


def test_fitted_models_have_a_verdict_on_every_parameter() -> None:
    best = validation().models["m1"]
    assert [i.name for i in best.identifiability] == list(best.names)
    assert all(i.why for i in best.identifiability)
    assert validation().models["m0"].identifiability == ()
    assert np.diag(best.correlation) == pytest.approx(np.ones(7))


def test_the_linearised_truth_is_near_the_responses() -> None:
    distances = {name: m.bode.distance["large"] for name, m in validation().models.items() if m.bode is not None}
    assert distances["m1"] < 0.1 < distances["m0"]


@pytest.mark.parametrize(
    ("least", "said"),
    [({"large": 99.0}, ()), ({"large": 100.5}, ("m1 fits large to 100.00 %, below the 100.5 % asked",))],
)
def test_thresholds(least: dict[str, float], said: tuple[str, ...]) -> None:
    demanding = config().model_copy(
        update={
            "validation": config().validation.model_copy(
                update={"thresholds": config().validation.thresholds.model_copy(update={"fit_percent": least})}
            )
        }
    )
    assert validate(demanding, recordings(), NOTHING, flex(), fits()).failed == said


def test_without_controller_no_loop_and_a_joint_that_cannot_flex_no_bode() -> None:
    plain = validate(config(), recordings(), NOTHING, FlexResult((), (), (), (), {}, ()), fits())
    assert plain.models["m1"].bode is None
    assert plain.models["m1"].records["small"].closed_loop is None


def test_a_fitted_model_may_be_called_m0() -> None:
    renamed = Fits({"m0": fits().models["m1"]}, "m0")
    assert list(validate(config(), recordings(), NOTHING, flex(), renamed).models) == ["initial", "m0"]


def test_it_goes_to_hdf5_and_back(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "validation.h5", "w") as file:
        codec.write(file, validation())
        again = codec.read(file, Validation)
    old, new = validation().models["m1"].records["large"], again.models["m1"].records["large"]
    assert new.fit_percent == old.fit_percent
    assert new.closed_loop == old.closed_loop
    np.testing.assert_array_equal(new.residual.crosscorrelation, old.residual.crosscorrelation)
    assert again.models["m1"].identifiability == validation().models["m1"].identifiability
    assert again.best == "m1"
