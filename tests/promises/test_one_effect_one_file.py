"""One effect, one file: a new file in the folder is an effect at once."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.paper_joint import STRUCTURE, TRUTH
from support.virtual_records import paper_records

import robotid.terms
from robotid.catalogue import assemble
from robotid.estimate.flexible import fit_flexible
from robotid.estimate.flexible_start import starts
from robotid.estimate.linear_response import fit_response, linear_part, linear_response, total_inertia
from robotid.estimate.notch import read_off
from robotid.estimate.rigid import fit_rigid
from robotid.model.discover import discover
from robotid.model.structure import Structure
from robotid.model.term import Motion, Term
from robotid.signals.frf import Frf
from robotid.terms import TERMS

QUADRATIC = '''
"""Drag."""

from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Partials, Term


class Drag(Term):
    """Churning of oil. Shows itself as friction that grows faster than speed."""

    name = "drag_for_a_test"
    ports = (Port.MOTOR,)
    parameters = (Parameter("Fq", "Nm s2/rad2", "drag", guess=0.0, null=0.0),)
    formula = "Fq v abs(v)"
    source = "a test"
    signature = "friction that grows faster than speed"

    def torque(self, m, p):
        return p[0] * m.v**2 * m.s

    def partials(self, m, p):
        return Partials(v=2.0 * p[0] * m.v * m.s, s=p[0] * m.v**2, theta=(m.v**2 * m.s,))
'''

FRICTION = QUADRATIC.replace("    signature =", "    friction = True\n    signature =")

GROUND = '''
"""Spring between arm and base."""

from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Partials, Role, Term


class Tether(Term):
    """A hose that pulls the arm back. Shows itself as a resonance below the notch."""

    name = "tether_for_a_test"
    ports = (Port.ARM,)
    parameters = (Parameter("kt", "Nm/rad", "stiffness", guess=1e3, bounds=(0.0, 1e9), null=0.0),)
    formula = "kt x"
    source = "a test"
    signature = "a resonance below the notch"
    linear = True
    role = Role.SPRING

    def torque(self, m, p):
        return p[0] * m.x

    def partials(self, m, p):
        return Partials(x=p[0], theta=(m.x,))
'''


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """One more folder of terms."""
    monkeypatch.setattr(robotid.terms, "__path__", [*robotid.terms.__path__, str(tmp_path)])
    known = set(sys.modules)
    yield tmp_path
    for module in {m for m in sys.modules if m.startswith("robotid.terms.")} - known:
        del sys.modules[module]
        vars(robotid.terms).pop(module.rpartition(".")[2], None)


def rediscover() -> dict[str, Term]:
    return discover("robotid.terms", robotid.terms.__path__, Term)


def drop_in(folder: Path, name: str, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """One more file in the folder of terms, and what a new process would find then."""
    (folder / f"{name}.py").write_text(text)
    monkeypatch.setitem(TERMS, name, rediscover()[name])


def test_a_new_file_is_known_at_once(folder: Path) -> None:
    (folder / "drag_for_a_test.py").write_text(QUADRATIC)
    found = rediscover()
    assert set(found) == {*robotid.terms.TERMS, "drag_for_a_test"}
    two = np.array([-2.0])
    m = Motion(two, two, two, np.array([-1.0]), two, np.zeros((0, 1)))
    assert found["drag_for_a_test"].torque(m, [0.5]) == pytest.approx(-2.0)


def test_nothing_is_left_behind() -> None:
    assert rediscover().keys() == robotid.terms.TERMS.keys()
    assert list(robotid.terms.TERMS) == sorted(robotid.terms.TERMS)


@pytest.mark.parametrize(
    ("file", "text", "found"),
    [
        ("misnamed.py", QUADRATIC, "Drag"),
        ("hollow.py", "from robotid.model.term import Term\n", "none"),
    ],
)
def test_a_file_that_is_no_effect_is_refused(folder: Path, file: str, text: str, found: str) -> None:
    (folder / file).write_text(text)
    name = file.removesuffix(".py")
    with pytest.raises(TypeError, match=f'must define one Term with name = "{name}"; it defines {found}$'):
        rediscover()


@pytest.mark.parametrize(("text", "fades"), [(FRICTION, 0.5), (QUADRATIC, 0.0)], ids=["friction", "no_friction"])
def test_a_new_friction_warms_up_with_the_others(
    folder: Path, text: str, fades: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the start of a record thermal_friction adds half of it, a long time later nothing."""
    drop_in(folder, "drag_for_a_test", text, monkeypatch)
    joint = assemble(Structure(("motor.inertia", "motor.drag_for_a_test", "motor.thermal_friction")))
    theta = joint.parameters().with_values({"motor.drag_for_a_test.Fq": 3.0, "motor.thermal_friction.c": 0.5}).values
    speed, still = np.full((1, 2), 2.0), np.zeros(2)
    force = joint.force(speed, still, np.ones((1, 2)), np.array([0.0, 1e9]), theta)
    assert force[0] == pytest.approx([-12.0 * (1.0 + fades), -12.0])


@pytest.mark.parametrize("kt", [2e4, 2e5, 6e5])
def test_a_new_spring_to_ground_reaches_the_linear_start(
    folder: Path, kt: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From its declared guess, far from the truth, to the stiffness that a made-up response has."""
    drop_in(folder, "tether_for_a_test", GROUND, monkeypatch)
    linear = linear_part(assemble(replace(STRUCTURE, terms=(*STRUCTURE.terms, "arm.tether_for_a_test"))))
    truth = TRUTH | {"arm.tether_for_a_test.kt": kt}
    omega = 2 * np.pi * np.arange(0.4, 40.2, 0.2)
    response = linear_response(linear, np.array([truth[name] for name in linear.names]), omega)
    frf = Frf("made up", omega / (2 * np.pi), response, 1e-3 * np.abs(response))
    declared = dict(zip(linear.names, linear.parameters().values, strict=True))
    total = total_inertia(linear, truth)
    begin = starts(linear, declared, read_off(frf), total, omega)
    fit = fit_response(linear, frf, {"motor.viscous.Fv": 0.013}, begin, (total, 0.01 * total))
    for name in linear.names:
        assert fit.values[name] == pytest.approx(truth[name], rel=1e-3), name


def test_init_flex_estimates_a_new_spring_to_ground(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drop_in(folder, "tether_for_a_test", GROUND, monkeypatch)
    structure = replace(STRUCTURE, terms=(*STRUCTURE.terms, "arm.tether_for_a_test"))
    set1, set2, set3 = paper_records(structure, TRUTH | {"arm.tether_for_a_test.kt": 5e3})
    joint = assemble(structure)
    rigid = fit_rigid(joint, joint.parameters(), [set1])
    flex = fit_flexible(joint, joint.parameters().with_values(rigid.guesses), rigid, [set2, set3])
    assert rigid.guesses["arm.tether_for_a_test.kt"] == pytest.approx(5e3, rel=0.05)
    assert flex.guesses["arm.tether_for_a_test.kt"] == pytest.approx(5e3, rel=0.2)
    assert flex.guesses["gear.spring.k1"] == pytest.approx(TRUTH["gear.spring.k1"], rel=0.05)
