"""The response of an axis by itself, from experiments in which all axes move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.coupled_axes import TRUTH, chain
from support.moving_axes import EXPERIMENTS

from robotid.catalogue import assemble
from robotid.config.load import parse_axes
from robotid.errors import ConfigError, NumericsError
from robotid.estimate.among_axes import response_among_axes
from robotid.estimate.flexible import FlexResult
from robotid.model.companion import CompanionKind
from robotid.signals.companion import Companion
from robotid.signals.quality import Recordings
from robotid.stages.collect import Common, collect
from robotid.stages.excite import excite
from robotid.stages.init_flex import init_flex
from robotid.stages.init_rigid import init_rigid

CONFIGS = parse_axes(EXPERIMENTS)
GROUPS = (("wide", "wide_r2"),)


@pytest.fixture(scope="module")
def collected() -> dict[str, Recordings]:
    common = Common()
    return {axis: collect(config, excite(config), {}, shared=common) for axis, config in CONFIGS.items()}


def found(axis: str, recordings: Recordings) -> FlexResult:
    return init_flex(CONFIGS[axis], recordings, init_rigid(CONFIGS[axis], recordings))


def arms_apart(axis: int) -> float:
    """Resonance of the arms while both motors stand that is nearest to that of the axis' own arm [rad/s]."""
    stiffness = np.diag([values[3] for values in TRUTH])
    inertia = chain().mass(np.array([[0.3], [1.0]]))[:, :, 0] + np.diag([values[5] for values in TRUTH])
    own = np.sqrt(stiffness[axis, axis] / inertia[axis, axis])
    both = np.sqrt(np.linalg.eigvals(np.linalg.solve(inertia, stiffness)).real)
    return float(both[np.argmin(np.abs(both - own))])


def test_the_experiments_of_a_virtual_robot_are_its_orthogonal_records() -> None:
    assert CONFIGS["a1"].init_flex.experiments == CONFIGS["a2"].init_flex.experiments == GROUPS


@pytest.mark.parametrize("axis", ["a1", "a2"])
def test_the_notch_of_an_axis_is_a_resonance_of_the_arms_while_all_motors_stand(
    axis: str, collected: dict[str, Recordings]
) -> None:
    flex = found(axis, collected[axis])
    (reading,) = flex.readings
    assert reading.notch == pytest.approx(arms_apart(int(axis[1]) - 1), rel=0.05)
    assert "standing, from 2 experiments" in " ".join(flex.remarks)
    Jm, k = TRUTH[int(axis[1]) - 1][0], TRUTH[int(axis[1]) - 1][3]
    assert flex.guesses["motor.inertia.J"] == pytest.approx(Jm, rel=0.15)
    assert flex.guesses["gear.spring.k1"] == pytest.approx(k, rel=0.2)


def test_scales_and_filters_of_the_other_axis_do_not_matter(collected: dict[str, Recordings]) -> None:
    rigid = init_rigid(CONFIGS["a1"], collected["a1"])
    plain = init_flex(CONFIGS["a1"], collected["a1"], rigid)

    def otherwise(companion: Companion) -> Companion:
        factor = -3.0 if companion.kind is CompanionKind.DRIVE else 0.5
        return Companion.of(companion.kind, factor * companion.values, 1e-3)

    records = tuple(
        replace(r, companions={name: otherwise(one) for name, one in r.companions.items()})
        for r in collected["a1"].records
    )
    again = init_flex(CONFIGS["a1"], replace(collected["a1"], records=records), rigid)
    assert again.frfs[0].response == pytest.approx(plain.frfs[0].response, rel=1e-9)


def test_records_of_one_axis_alone_are_refused(collected: dict[str, Recordings]) -> None:
    bare = [replace(collected["a1"][name], companions={}) for name in GROUPS[0]]
    one = assemble(CONFIGS["a1"].structure())
    with pytest.raises(NumericsError, match="no other axis whose angle and torque are recorded"):
        response_among_axes(one, one.parameters(), [bare])


@pytest.mark.parametrize(
    ("given", "what"),
    [
        ("[[wide, wide_r9]]", r'init_flex\.experiments\[0\]\[1\].*no record "wide_r9"'),
        ("[[wide]]", r"init_flex\.experiments\[0\].*1 experiments, whose records show angle and torque of a2"),
        ("[[turning, wide]]", r"init_flex\.experiments\[0\]\[0\].*turning serves no initialisation"),
    ],
)
def test_experiments_that_tell_nothing_are_refused(given: str, what: str) -> None:
    with pytest.raises(ConfigError, match=what):
        parse_axes(f"{EXPERIMENTS}init_flex: {{experiments: {given}}}\n")


def test_measured_experiments_have_the_torques_of_all_axes() -> None:
    text = """\
robot:
  name: arm
  axes:
    a1: {gear_ratio: 0.01, model: {motor: [inertia]}, columns: {tau_m: u, phi_m: x}}
    a2: {gear_ratio: 0.01, model: {motor: [inertia]}, columns: {tau_m: v, phi_m: y}}
records: [{name: one, file: one.csv}, {name: two, file: two.csv}]
init_flex: {experiments: [[one, two]]}
"""
    signals = parse_axes(text)["a1"].records[1].signals
    found = {name: (one.name, one.kind) for name, one in signals.items()}
    assert found == {"a2": ("y", "angle"), "tau_a2": ("v", "drive")}
