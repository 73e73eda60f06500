"""The equations as text are those of the joint, for every effect of the catalogue and in every language."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from support.handed_models import handed
from support.matlab_reader import Matlab

from robotid.channels import CHANNELS
from robotid.export.equations.trace import acts_at_once
from robotid.export.handover.function import cannot_be_written
from robotid.export.handover.handed_model import HandedModel
from robotid.export.targets.matlab_function import MatlabFunction
from robotid.export.targets.python_function import PythonFunction
from robotid.model.array import Array
from robotid.model.port import Signal
from robotid.terms import TERMS

BASE = ("motor.inertia", "motor.viscous", "motor.coulomb", "gear.spring", "gear.damper", "arm.inertia")
POINTS = 6


def places() -> list[str]:
    return [f"{port}.{name}" for name, term in TERMS.items() for port in term.ports if term.companion is None]


def with_effect(effect: str) -> HandedModel:
    """The usual joint and one effect more, on a tool where it asks for one."""
    more = ("link.spring", "tool.inertia") if effect.startswith(("link", "tool")) else ()
    model = handed((*BASE, *(e for e in more if e != effect), *((effect,) if effect not in BASE else ())))
    generator = np.random.default_rng(1)
    values = {p.name: p.value * generator.uniform(0.8, 1.2) or 0.3 for p in model.fit.parameters}
    return model.with_structure(model.fit.structure, values)


def motions(model: HandedModel) -> tuple[Array, Array, Array]:
    """States (nx, n), torques and times (n,), nowhere near rest or an edge that is at zero."""
    joint, generator = model.joint, np.random.default_rng(2)
    x = generator.standard_normal((joint.nx, POINTS))
    x[: joint.masses - 1] *= 1e-3
    x[joint.speeds.stop :] *= 0.3
    return x, generator.standard_normal(POINTS), np.linspace(0.0, 2.0, POINTS)


def of_the_joint(model: HandedModel) -> Array:
    x, u, t = motions(model)
    joint = model.joint
    return np.asarray(joint.evaluate(x, u, np.sign(x[joint.speeds]), t, model.theta).f)


def run(text: str) -> dict[str, Any]:
    names: dict[str, Any] = {}
    exec(compile(text, "exported", "exec"), names)
    return names


def of_the_python(model: HandedModel) -> Array:
    names = run(PythonFunction().text(model, ["head"]))
    names["SMOOTHING"] = (1e-12,) * 3
    x, u, t = motions(model)
    assert names["STATES"] == model.joint.state_names
    return np.array([names["derivatives"](t[k], x[:, k], u[k]) for k in range(POINTS)]).T


def of_the_matlab(model: HandedModel) -> Array:
    """The whole MATLAB file, run by a reader of its grammar, with dry friction as sharp as that of the joint."""
    text = MatlabFunction().text(model, ["head"])
    sharp = re.sub(r"smoothing = \[[^\]]*\]", "smoothing = [1e-12 1e-12 1e-12]", text)
    assert sharp != text
    file = Matlab(sharp)
    name, x, u, t = next(iter(file.functions)), *motions(model)
    return np.array([file.call(name, t[k], x[:, k], u[k])[:, 0] for k in range(POINTS)]).T


@pytest.mark.parametrize("effect", places())
def test_every_effect_is_written_as_the_joint_has_it(effect: str) -> None:
    model = with_effect(effect)
    assert cannot_be_written(model) == {}
    expected = of_the_joint(model)
    np.testing.assert_allclose(of_the_python(model), expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(of_the_matlab(model), expected, rtol=1e-9, atol=1e-9)


def test_a_matlab_file_gives_its_parameters_and_takes_others() -> None:
    model = handed(BASE)
    file = Matlab(MatlabFunction().text(model, ["head"]))
    name, x, u, t = next(iter(file.functions)), *motions(model)
    given = file.call(name)
    assert given["motor_viscous_Fv"] == next(p.value for p in model.fit.parameters if p.name == "motor.viscous.Fv")
    usual = file.call(name, t[0], x[:, 0], u[0])
    np.testing.assert_array_equal(file.call(name, t[0], x[:, 0], u[0], given), usual)
    assert (file.call(name, t[0], x[:, 0], u[0], {**given, "motor_viscous_Fv": 9.0}) != usual).any()


@pytest.mark.parametrize(
    "wrong",
    [
        "y = q;",
        "y = x(0);",
        "y = 2 ** x(1);",
        "y = x(1)",
        "y = [x(1), x(2);",
        "y = none(x(1));",
        "if x(1) > 0",
        "y = x[1];",
    ],
)
def test_what_is_no_matlab_is_refused(wrong: str) -> None:
    with pytest.raises((AssertionError, IndexError)):
        Matlab(f"function y = f(x)\n{wrong}\nend\n").call("f", np.ones(2))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-2^2", -4.0),
        ("2^3^2", 64.0),
        ("2^-1", 0.5),
        ("6 / 3 * 2", 4.0),
        ("pick(1 < 2, 3, 4)", 3.0),
        ("x(2) - -1", 3.0),
    ],
)
def test_the_reader_has_the_precedence_of_matlab(text: str, value: float) -> None:
    pick = "function y = pick(c, a, b)\nif c\ny = a;\nelse\ny = b;\nend\nend\n"
    assert Matlab(f"function y = f(x)\ny = {text};\nend\n{pick}").call("f", np.array([1.0, 2.0])) == value


def test_a_space_before_a_sign_begins_an_element() -> None:
    file = Matlab("function y = f(x)\ny = [x(1) -x(2); 1 - 2, 3];\nend\n")
    np.testing.assert_array_equal(file.call("f", np.array([5.0, 7.0])), [[5.0, -7.0], [-1.0, 3.0]])


def test_an_effect_changes_the_text() -> None:
    plain, more = (PythonFunction().text(handed((*BASE, *extra)), []) for extra in ((), ("motor.stribeck",)))
    assert plain != more


def test_what_reads_a_recorded_signal_is_left_out() -> None:
    model = handed((*BASE, "arm.pose_gravity[q2]"))
    assert cannot_be_written(model) == {"arm.pose_gravity[q2]": "it reads q2, which is recorded"}
    found = PythonFunction().hand_over(model)
    assert "It lacks arm.pose_gravity[q2]: it reads q2, which is recorded." in found.text


def test_channels_without_memory_are_written_and_others_are_left_out() -> None:
    named = [f"{c.signals[0]}.{name}" for name, c in CHANNELS.items() if c.companion is None]
    model = handed(BASE, tuple(named))
    omitted = cannot_be_written(model)
    for name in named:
        signal, _, channel = name.partition(".")
        p = [q.guess for q in CHANNELS[channel].parameters]
        written = signal == Signal.TORQUE and acts_at_once(CHANNELS[channel], p)
        assert (name not in omitted) == written, name
    assert "torque.torque_lag" in omitted
    assert "torque.torque_gain" not in omitted


def test_a_gain_of_the_torque_acts() -> None:
    model = handed(BASE, ("torque.torque_gain",))
    names = run(PythonFunction().text(model, []))
    gain = model.fit["torque.torque_gain.g"].value if "torque.torque_gain.g" in model.joint.names else model.theta[-1]
    x = [0.0, 0.0, 2.0, 0.02]
    with_one, with_two = (np.array(names["derivatives"](0.0, x, u)) for u in (1.0, 2.0))
    expected = CHANNELS["torque_gain"].apply(np.array([1.0, 2.0]), 1e-3, [float(gain)])
    difference = (with_two - with_one)[2] * model.fit["motor.inertia.J"].value
    assert difference == pytest.approx(float(np.diff(expected)[0]))
