"""The trials on two axes: draws repeat, and what the tool names is judged as it should be."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from math import isnan

import numpy as np
import pytest

from study.axes.arms import draw
from study.axes.files import COUPLING, POSE, STRUCTURE, hidden, truth
from study.axes.plan import KINDS, every
from study.axes.table import table
from study.axes.trial import Result, drawn_extra

NAMED = Result("pose-0", "pose", POSE, causes=((POSE, (POSE, "arm.pose_lever[q2]")),))


def test_the_plan_holds_every_kind_as_often() -> None:
    specs = list(every(4))
    assert Counter(spec.kind for spec in specs) == dict.fromkeys(KINDS, 4)
    assert len({spec.friction for spec in specs if spec.kind == "friction"}) == 4


def test_draws_repeat_and_differ() -> None:
    one, again, other = (draw(np.random.default_rng(seed)) for seed in (5, 5, 6))
    assert one.joints == again.joints != other.joints
    assert np.array_equal(one.plans[1].refs[0], again.plans[1].refs[0])


def test_the_truth_names_every_parameter_that_the_oracle_starts_from() -> None:
    for spec in every(4):
        rng = spec.rng()
        arms, extra = draw(rng), drawn_extra(spec, rng)
        effects = {name.rpartition(".")[0] for name in truth(arms, extra)}
        assert effects == {*STRUCTURE} | ({hidden(spec)} - {""})


@pytest.mark.parametrize(
    ("causes", "first", "in_class", "false"),
    [
        (((POSE, (POSE,)),), True, True, 0),
        ((("arm.pose_lever[q2]", ("arm.pose_lever[q2]", POSE)),), True, True, 0),
        ((("motor.pose_lever[q2]", ("motor.pose_lever[q2]", POSE)),), False, True, 0),
        (((COUPLING, (COUPLING,)), (POSE, (POSE,))), False, False, 1),
        ((), False, False, 0),
    ],
)
def test_causes_are_judged(
    causes: tuple[tuple[str, tuple[str, ...]], ...], first: bool, in_class: bool, false: int
) -> None:
    judged = replace(NAMED, causes=causes)
    assert (judged.first, judged.in_class, judged.false) == (first, in_class, false)


def test_the_gain_is_a_share_of_the_oracles() -> None:
    rmse = {"base": 0.10, "oracle": 0.02, "extended": 0.024}
    assert replace(NAMED, rmse=rmse).share == pytest.approx(0.95)
    clean = Result("clean-0", "clean", "", causes=((POSE, (POSE,)),))
    assert isnan(clean.share)
    assert clean.false == 1
    assert "| nothing | 1 | - | - | 1 in 1 trials |" in table([clean])
