"""Under the conditions of real recordings nothing is named where nothing is hidden, nor a stranger as an effect."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from robotid.config.load import load
from robotid.pipeline.execute import execute
from robotid.pipeline.run import Run
from study.conditional.plan import PLAIN, Spec
from study.conditional.trial import Result, prepared, run
from study.plant.conditions import CONDITIONS
from study.plant.strangers import STRANGERS
from study.trials.study import in_scratch

DRAW = 200
"""Far from the numbers that a study draws."""
LONG = {
    "jitter of 10 %",
    "five times the noise",
    "torque error a random walk",
    "torque ripple of 2 %",
    "friction that drifts",
    "shaken_base",
    "quadratic_gear_damping",
    "stiffness_by_angle",
    "friction_step",
    "torque error AR 0.9",
    "4096 counts",
    "held-out record with the fit's motion",
}
"""Those that take longest, or are much like one of the others."""


def marked(names: Iterable[str]) -> list[Any]:
    return [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in names]


@cache
def trial(condition: str, kind: str, name: str) -> Result:
    return in_scratch(lambda folder: run(Spec(condition, kind, name, DRAW), folder))


@pytest.mark.parametrize("condition", marked(CONDITIONS))
def test_a_machine_without_anything_hidden_is_given_no_cause(condition: str) -> None:
    found = trial(condition, "clean", "none")
    assert (found.error, found.causes) == ("", ())


@pytest.mark.parametrize("name", marked(STRANGERS))
def test_what_no_effect_of_the_catalogue_is_does_not_bear_the_name_of_one(name: str) -> None:
    found = trial(PLAIN, "stranger", name)
    assert (found.error, found.causes) == ("", ())


@pytest.mark.parametrize(
    "condition",
    [
        "angle alone",
        pytest.param("4 ms", marks=pytest.mark.slow),
        pytest.param("torque error AR 0.99", marks=pytest.mark.slow),
    ],
)
def test_a_true_effect_is_the_first_that_is_named(condition: str) -> None:
    found = trial(condition, "effect", "gear.soft_spring")
    assert found.first
    assert found.false == 0


def test_a_coarse_encoder_does_not_make_the_torque_noisy(tmp_path: Path) -> None:
    """Of most samples of a slow motion it shows no difference at all, as if it had no noise: what it adds passed for
    errors of the torque of 165 Nm, and every parameter for known to a hundred thousand times what it is."""
    case, _ = prepared(Spec("4096 counts", "effect", "motor.quadratic_friction", 4200))
    case.write(tmp_path)
    complete = "robot.model.motor=[inertia, viscous, coulomb, quadratic_friction]"
    fitted = Run(load(tmp_path / "base.yaml", (complete,)), tmp_path)
    for stage in ("collect", "init-rigid", "init-flex"):
        execute(fitted, stage)
    fits = execute(fitted, "fit").content
    for one in fits.models[fits.best].parameters:
        assert 0.0 < one.std_robust < 3.0 * one.std
