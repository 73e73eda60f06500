"""`rid.state_space`: in python-control a model answers and moves as it does here."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.handed_models import RATIO, STEP, VALUES, driven, fit_of

import robotid as rid
from robotid.catalogue import assemble
from robotid.extension import Extension
from robotid.model.linear import linearise

control: Any = pytest.importorskip("control", reason="needs the extra control")

LINEAR = ("motor.inertia", "motor.viscous", "gear.spring", "gear.damper", "arm.inertia")
RIGID = rid.Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
TOOL = rid.Structure((*LINEAR, "motor.coulomb", "link.spring", "link.damper", "tool.inertia"), gear_ratio=RATIO)
OMEGA = 2 * np.pi * np.geomspace(0.3, 100, 40)


@pytest.mark.parametrize(("structure", "speed"), [(RIGID, 0.0), (TOOL, 0.0), (TOOL, 10.0)])
def test_it_answers_as_the_linearised_model(structure: rid.Structure, speed: float) -> None:
    fit = fit_of(structure, VALUES)
    found = rid.state_space(fit, speed=speed)
    theta = np.array([p.value for p in fit.parameters])
    expected = linearise(assemble(structure), theta, speed).speed_response(OMEGA)
    answer = control.frequency_response(found["dphi_m", "tau_m"], OMEGA).complex
    np.testing.assert_allclose(answer, expected, rtol=1e-8)
    assert (found.name, found.input_labels) == ("m", ["tau_m"])
    assert len(found.state_labels) == found.nstates == len(found.A)


def test_it_moves_as_the_model_does() -> None:
    model, record = driven(LINEAR)
    found = rid.state_space(model.fit)["dphi_m", "tau_m"].sample(STEP, "zoh")
    speed = control.forced_response(found, record.t, record.tau_m).outputs
    error = np.sqrt(np.mean((speed - record.dphi_m) ** 2))
    assert error < 1e-6 * np.sqrt(np.mean(record.dphi_m**2))


def test_an_extension_is_its_fit() -> None:
    fit = fit_of(TOOL, VALUES)
    extension = Extension("m", "speed", "rad/s", (), (), ("motor.coulomb",), {}, {}, 0.0, 0.0, fit, ())
    np.testing.assert_array_equal(rid.state_space(extension).A, rid.state_space(fit).A)


def test_what_is_left_out_is_warned_of() -> None:
    fit = fit_of(replace(RIGID, channels=("torque.torque_delay",)), VALUES)
    with pytest.warns(UserWarning, match=r"no part of the state space: torque\.torque_delay"):
        rid.state_space(fit)


def test_what_it_needs_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(rid.RobotidError, match="int is no fitted model"):
        rid.state_space(3)  # type: ignore[arg-type]
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(rid.RobotidError, match=r"needs python-control; pip install 'robotid\[control\]'"):
        rid.state_space(fit_of(RIGID, VALUES))
