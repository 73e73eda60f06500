"""The study's own judgement: a trial that is judged wrongly proves nothing."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from math import isnan, nan
from pathlib import Path

import numpy as np
import pytest
from support.paths import ROOT

from robotid.config.load import load
from robotid.diagnosis.misfit.curve import Curve
from study.conditional.plan import every as under_conditions
from study.plant.catalogue import EFFECTS, UNKNOWN
from study.plant.draw import draw
from study.plant.experiment import Loop, Recording, experiment
from study.plant.references import triangle
from study.plant.rig import Base, Rig
from study.trials import study as studied
from study.trials.case import Case, Hidden
from study.trials.judgement import judge
from study.trials.plan import Spec, every
from study.trials.shape import correlation
from study.trials.sizing import cost
from study.trials.table import BEGIN, END, PAGE, table, write
from study.trials.trial import Result

EFFECT = Result(
    "k", "effect", ("motor.stribeck",), 4.0, cost=4.0, rmse={"base": 0.1, "oracle": 0.02, "extended": 0.021}
)
STRIBECK, COGGING = ("motor.stribeck", ("motor.stribeck", "motor.presliding")), ("motor.cogging", ("motor.cogging",))
TWIN = ("motor.presliding", ("motor.presliding", "motor.stribeck"))


@pytest.mark.parametrize(
    ("causes", "right", "in_class", "false", "missed"),
    [
        ((STRIBECK,), True, True, 0, False),
        ((TWIN,), False, True, 0, False),
        ((COGGING, STRIBECK), False, False, 1, False),
        ((STRIBECK, COGGING), True, True, 1, False),
        ((), False, False, 0, True),
    ],
)
def test_one_effect(
    causes: tuple[tuple[str, tuple[str, ...]], ...], right: bool, in_class: bool, false: int, missed: bool
) -> None:
    judged = judge(replace(EFFECT, verdict="named" if causes else "clean", causes=causes))
    assert (judged.right, judged.in_class, judged.false, judged.missed) == (right, in_class, false, missed)
    assert judged.share == pytest.approx(0.079 / 0.08)


def test_a_pair_needs_both_and_a_class_will_do() -> None:
    pair = replace(EFFECT, kind="pair", hidden=("motor.stribeck", "motor.cogging"))
    assert judge(replace(pair, causes=(COGGING, STRIBECK))).right
    one_by_class = judge(replace(pair, causes=(COGGING, TWIN)))
    assert (one_by_class.right, one_by_class.in_class, one_by_class.false) == (False, True, 0)
    assert not judge(replace(pair, causes=(COGGING,))).in_class


@pytest.mark.parametrize(("kind", "verdict"), [("clean", "clean"), ("unknown", "unknown")])
def test_clean_and_unknown_are_judged_by_the_verdict(kind: str, verdict: str) -> None:
    result = replace(EFFECT, kind=kind, hidden=(), cost=0.1, rmse={"base": 0.02})
    assert judge(replace(result, verdict=verdict)).right
    assert not judge(replace(result, verdict="named", causes=(COGGING,))).right
    assert not judge(replace(result, verdict="", error="stopped")).right


def test_small_effects_are_set_apart_and_errors_are_not() -> None:
    assert judge(EFFECT).worth
    assert not judge(replace(EFFECT, cost=2.9)).worth
    stopped = judge(replace(EFFECT, cost=nan, rmse={}, error="diverged"))
    assert stopped.worth
    assert not stopped.in_class
    assert isnan(stopped.share)


def test_the_plan_is_what_was_asked_for() -> None:
    specs = list(every())
    of = Counter((spec.kind, spec.names, spec.size) for spec in specs if spec.kind == "effect")
    assert len(of) == 2 * len(EFFECTS)
    assert set(of.values()) == {5}
    assert Counter(spec.kind for spec in specs) >= Counter(clean=50, pair=20, unknown=20)
    assert len({spec.key for spec in specs}) == len(specs)
    assert len({spec.names for spec in specs if spec.kind == "unknown"}) >= 4


def test_draws_that_begin_at_another_number_are_as_many_and_others() -> None:
    kinds, later = Counter(spec.kind for spec in every()), list(every(first=100))
    assert Counter(spec.kind for spec in later) == kinds
    assert not {spec.key for spec in later} & {spec.key for spec in every()}
    conditional = [{spec.key for spec in under_conditions(3, 1, first)} for first in (0, 100)]
    assert len(conditional[0]) == len(conditional[1])
    assert not conditional[0] & conditional[1]


def test_cost_is_the_misfit_beyond_the_noise() -> None:
    assert cost(0.05, 0.03) == pytest.approx(4 / 3)
    assert cost(0.02, 0.03) == 0.0


def test_the_table_stands_between_its_marks_and_can_be_written_again(tmp_path: Path) -> None:
    results = [replace(EFFECT, causes=(STRIBECK,)), replace(EFFECT, key="l", causes=()), replace(EFFECT, cost=1.0)]
    text = table(results)
    assert "| motor.stribeck | 2 | 50 % | 50 % | 0 | 1 | 98.8 % |" in text
    assert "1 more trials" in text
    page = tmp_path / "validation.md"
    page.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n")
    write(page, text)
    once = page.read_text()
    write(page, text)
    assert page.read_text() == once == f"before\n{BEGIN}\n{text}\n{END}\nafter\n"


def test_the_manual_has_a_place_for_the_table_and_no_other_page_is_harmed(tmp_path: Path) -> None:
    page = (ROOT / PAGE).read_text(encoding="utf-8")
    assert page.count(BEGIN) == page.count(END) == 1
    (tmp_path / "other.md").write_text("no marks here")
    with pytest.raises(ValueError, match="lacks the marks"):
        write(tmp_path / "other.md", "table")
    assert (tmp_path / "other.md").read_text() == "no marks here"


def test_a_study_begins_where_it_was_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    specs = [Spec("clean", (), "none", number) for number in range(3)]
    tried: list[int] = []

    def run(spec: Spec, folder: Path) -> Result:
        tried.append(spec.number)
        if spec.number == 1:
            raise ZeroDivisionError("a bug")
        return replace(EFFECT, key=spec.key, causes=(STRIBECK,), noise=0.02, correlation=0.5)

    monkeypatch.setattr(studied, "run", run)
    monkeypatch.setattr(studied, "digest", lambda: "this code")
    for spec in specs[:2]:
        studied._one(spec, tmp_path, patience=60)
    done: list[studied.Progress] = []
    studied.study(specs[:2], tmp_path, 1, 60, done.append)
    first, bug = studied.finished(tmp_path)
    assert (tried, done) == ([0, 1], [])
    assert first == run(specs[0], tmp_path)
    assert "ZeroDivisionError" in bug.error
    monkeypatch.setattr(studied, "digest", lambda: "other code")
    assert list(studied.finished(tmp_path)) == []


@pytest.fixture(scope="module")
def bumpy() -> tuple[Hidden, Recording]:
    hidden = Hidden("speed_bump", 0.3, {"v0": 10.0, "width": 2.0})
    rig = hidden.into(Rig(Base()), "slow")
    return hidden, experiment(rig, Loop(), triangle(20.0, 2.0, 2.0, 1e-3), 1e-3, 0)


def curve(along: str, x: np.ndarray, torque: np.ndarray) -> Curve:
    return Curve(along, "rad/s", x, torque, 0 * x, 0 * x + 100, 1.0)


def test_the_true_shape_correlates_with_itself_and_not_with_another(bumpy: tuple[Hidden, Recording]) -> None:
    hidden, recording = bumpy
    v = np.linspace(-18.0, 18.0, 37)
    bump = np.exp(-(((np.abs(v) - 10.0) / 2.0) ** 2)) * np.sign(v)
    taken = np.column_stack([v, np.sign(v)])
    left = bump - taken @ np.linalg.lstsq(taken, bump, rcond=None)[0]
    assert correlation(curve("dphi_m", v, -left), hidden, {"slow": recording}) > 0.97
    assert correlation(curve("dphi_m", v, left), hidden, {"slow": recording}) < -0.97
    assert abs(correlation(curve("t", np.linspace(0.1, 1.9, 37), -left), hidden, {"slow": recording})) < 0.5
    assert isnan(correlation(curve("frequency", v, -left), hidden, {"slow": recording}))


@pytest.mark.parametrize("name", [*EFFECTS, *UNKNOWN])
def test_the_tool_takes_the_configurations_of_every_case(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    effect = (EFFECTS | UNKNOWN)[name]
    case = Case(draw(rng), (Hidden(name, effect.size, effect.shape(rng)),))
    case.write_configs(tmp_path)
    base, oracle = (load(tmp_path / f"{which}.yaml").config for which in ("base", "oracle"))
    assert name not in base.structure().effects
    assert set(oracle.structure().effects) - set(base.structure().effects) == {name} - set(UNKNOWN)
