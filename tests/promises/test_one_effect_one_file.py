"""One effect, one file: a new file in the folder is an effect at once."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import robotid.terms
from robotid.model.discover import discover
from robotid.model.term import Motion, Term

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


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """One more folder of terms."""
    monkeypatch.setattr(robotid.terms, "__path__", [*robotid.terms.__path__, str(tmp_path)])
    known = set(sys.modules)
    yield tmp_path
    for module in set(sys.modules) - known:
        monkeypatch.delitem(sys.modules, module)
        monkeypatch.delattr(robotid.terms, module.rpartition(".")[2], raising=False)


def rediscover() -> dict[str, Term]:
    return discover("robotid.terms", robotid.terms.__path__, Term)


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
