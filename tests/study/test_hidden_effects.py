"""A fixed selection of the trials that `make trials` runs in full: an effect hidden in files, found and paid for."""

from __future__ import annotations

from pathlib import Path

import pytest

from study.trials.judgement import SHAPE, SHARE, Judgement, judge
from study.trials.plan import Spec, every
from study.trials.trial import Result, run

EFFECTS = (
    "effect-motor_stribeck-large-0",
    pytest.param("effect-torque_torque_delay-large-0", marks=pytest.mark.slow),
    pytest.param("effect-motor_position_friction-large-0", marks=pytest.mark.slow),
    pytest.param("effect-gear_soft_spring-large-0", marks=pytest.mark.slow),
    pytest.param("effect-arm_coulomb-large-0", marks=pytest.mark.slow),
)


def tried(key: str, folder: Path) -> tuple[Result, Judgement]:
    """A trial of the study, by its key. The study draws the same."""
    spec: Spec = next(one for one in every() if one.key == key)
    result = run(spec, folder)
    assert result.error == ""
    return result, judge(result)


@pytest.mark.parametrize("key", EFFECTS)
def test_a_hidden_effect_is_named_and_the_extended_model_gains_what_the_true_one_would(
    key: str, tmp_path: Path
) -> None:
    result, judged = tried(key, tmp_path)
    assert judged.worth
    assert judged.in_class, result.causes
    assert judged.false == 0, result.causes
    assert judged.share >= SHARE


@pytest.mark.slow
@pytest.mark.parametrize(
    "key", ["pair-arm_viscous-motor_stribeck-small-1", "pair-motor_coulomb-torque_torque_delay-small-16"]
)
def test_both_effects_of_a_pair_are_named(key: str, tmp_path: Path) -> None:
    result, judged = tried(key, tmp_path)
    assert judged.in_class, result.causes
    assert judged.false == 0, result.causes
    assert judged.share >= SHARE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "along"),
    [
        ("unknown-tight_spot-large-0", "phi_m, by direction"),
        ("unknown-tight_spot-small-0", "phi_m, by direction"),
        ("unknown-breathing-large-1", "t, by direction"),
        ("unknown-speed_bump-small-0", "dphi_m"),
    ],
)
def test_an_effect_of_no_catalogue_is_told_as_unknown_with_its_shape(key: str, along: str, tmp_path: Path) -> None:
    result, judged = tried(key, tmp_path)
    assert judged.right, (result.verdict, result.causes)
    assert result.along == along
    assert result.correlation >= SHAPE


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 3])
def test_nothing_is_named_on_a_clean_machine(number: int, tmp_path: Path) -> None:
    result, _ = tried(f"clean-none-{number}", tmp_path)
    assert (result.verdict, result.causes) == ("clean", ())
    assert result.rmse["extended"] < 1.05 * result.noise
