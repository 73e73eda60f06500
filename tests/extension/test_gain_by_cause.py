"""What a fit as the pipeline makes it confirms of causes that act alike."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.small_bench import AXIS, TRUTH, FitOptions, records_of

from robotid.catalogue import assemble
from robotid.diagnosis.results import Cause, Diagnosis
from robotid.diagnosis.verdict import not_explained
from robotid.estimate.fitted_model import fitted_model, simulate_records
from robotid.estimate.grey_box import fit_model
from robotid.extension import gain_by_cause
from robotid.extension.gain_by_cause import Known, gains, with_gains
from robotid.extension.task import ExtensionTask, extension_task
from robotid.interrupt import OutOfTime

UNCERTAIN = "a fit does not confirm it: its size is not known"
POWER, QUADRATIC = "motor.power_friction", "motor.quadratic_friction"
HIDDEN = {f"{POWER}.Fp": 0.1, f"{POWER}.alpha": 0.5}


def named(effects: tuple[str, ...], values: dict[str, float]) -> tuple[Diagnosis, ExtensionTask]:
    """Causes that a search has named on an axis whose friction grows like the root of the speed, and the task to extend
    it. values : at which the search has left their parameters."""
    plant = assemble(AXIS.extended(POWER), angle=True)
    made = records_of(plant, TRUTH | HIDDEN)
    joint = assemble(AXIS)
    fit = fit_model("m", joint, joint.parameters().with_values(TRUTH), made[:2], FitOptions())
    model = fitted_model(fit)
    empty = not_explained(model, list(simulate_records(model, made)))
    causes = tuple(Cause(effect, (), 0.4, 1.0, 1e-9, (effect,), None, ()) for effect in effects)
    found = replace(empty, verdict="named", causes=causes, refitted=empty.refitted | values, remaining_share=0.2)
    return found, extension_task(found, fit, made)


def test_of_causes_that_act_alike_the_one_that_explains_less_goes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each had no size beside the other, and none was left."""

    def beside_another(diagnosis: Diagnosis, *_: object) -> dict[str, str]:
        return {one.effect: UNCERTAIN for one in diagnosis.causes} if len(diagnosis.causes) > 1 else {}

    for name in ("unconfirmed", "unsized"):
        monkeypatch.setattr(gain_by_cause, name, beside_another)
    astray = {f"{QUADRATIC}.Fq": 1e-5, f"{POWER}.Fp": -1e-3, f"{POWER}.alpha": 1.6}
    left = with_gains(*named((QUADRATIC, POWER), astray))
    (cause,) = left.causes
    assert cause.effect == POWER
    size, power = cause.parameters
    assert size.value == pytest.approx(0.1, abs=3.0 * size.std_robust)
    assert power.value == pytest.approx(0.5, abs=3.0 * power.std_robust)
    (rejected,) = left.rejected
    assert rejected.effect == QUADRATIC
    assert rejected.why == UNCERTAIN


def test_what_was_fitted_without_a_cause_is_not_fitted_again_where_that_goes() -> None:
    _, task = named((POWER,), {f"{POWER}.Fp": 0.1, f"{POWER}.alpha": 0.5})
    known: Known = {}
    both, _ = gains(task, (POWER, QUADRATIC), known)
    assert set(known) == {(), (POWER,), (POWER, QUADRATIC)}
    before = known[()]
    (alone,), last = gains(task, (POWER,), known)
    assert known[()] is before
    assert alone == pytest.approx(both[0], abs=1e-6)
    assert last is not None
    assert all(p.std_robust > 0.0 for p in last.parameters if p.name.startswith(POWER))


def test_where_time_runs_out_over_causes_that_act_alike_all_stay_as_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def too_late(*_: object) -> None:
        raise OutOfTime

    for name in ("unconfirmed", "unsized"):
        monkeypatch.setattr(gain_by_cause, name, lambda found, *_: {one.effect: UNCERTAIN for one in found.causes})
    monkeypatch.setattr(gain_by_cause, "tried_with", too_late)
    found, task = named((POWER, QUADRATIC), {f"{QUADRATIC}.Fq": 1e-5, f"{POWER}.Fp": 0.1, f"{POWER}.alpha": 0.5})
    left = with_gains(found, replace(task, records=task.records[:2]))
    assert [cause.effect for cause in left.causes] == [POWER, QUADRATIC]
    assert left.remarks[-1].endswith("are those of the search: no time was left to fit them")


def test_gains_beside_a_cause_that_went_are_said_to_be_that(monkeypatch: pytest.MonkeyPatch) -> None:
    """No time is left to fit the other once more."""
    found, task = named((POWER, QUADRATIC), {f"{QUADRATIC}.Fq": 1e-5, f"{POWER}.Fp": 0.1, f"{POWER}.alpha": 0.5})
    asked = list[tuple[str, ...]]()

    def once(task: ExtensionTask, effects: tuple[str, ...], known: Known, begun: None) -> object:
        asked.append(tuple(effects))
        if len(asked) > 1:
            raise OutOfTime
        return gains(task, effects, known, begun)

    monkeypatch.setattr(gain_by_cause, "gains", once)
    monkeypatch.setattr(gain_by_cause, "unconfirmed", lambda *_: {QUADRATIC: UNCERTAIN})
    monkeypatch.setattr(gain_by_cause, "unsized", lambda *_: {})
    left = with_gains(found, task)
    assert asked == [(POWER, QUADRATIC), (POWER,)]
    assert [cause.effect for cause in left.causes] == [POWER]
    assert left.remarks[-1].endswith("with others, which it did not confirm: no time was left to fit them")
