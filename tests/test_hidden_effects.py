"""A fixed selection of the trials that `make trials` runs in full: an effect hidden in files, found and paid for."""

from __future__ import annotations

from pathlib import Path

import pytest
from hidden.study.judgement import SHARE, judge
from hidden.study.plan import Spec
from hidden.study.trial import run


@pytest.mark.parametrize("name", ["motor.stribeck", "gear.damper", "torque.torque_delay"])
def test_a_hidden_effect_is_named_and_the_extended_model_gains_what_the_true_one_would(
    name: str, tmp_path: Path
) -> None:
    result = run(Spec("effect", (name,), "large", 0), tmp_path)
    judged = judge(result)
    assert result.error == ""
    assert judged.worth
    assert judged.in_class
    assert judged.share >= SHARE


def test_nothing_is_named_on_a_clean_machine(tmp_path: Path) -> None:
    result = run(Spec("clean", (), "none", 0), tmp_path)
    assert (result.error, result.verdict, result.causes) == ("", "clean", ())
    assert result.rmse["extended"] < 1.05 * result.noise
