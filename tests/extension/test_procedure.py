"""Extending a model by its causes: the gain is that of a simulation by other means, and what has none is dropped."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from support.diagnosed import NAMED
from support.diagnosed import STRIBECK as CAUSE
from support.small_bench import SAMPLING_TIME, TRUTH, fitted, records

from robotid.diagnosis.criteria import Criteria
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel, Simulated, fitted_model
from robotid.estimate.result import FitResult
from robotid.extension import ExtensionTask, extend, extension_task, gains, with_gains
from robotid.extension import task as fits
from robotid.extension.results import Extension
from robotid.extension.scored_starts import scored_starts
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Record

STRIBECK = {"motor.stribeck.dFs": 0.15, "motor.stribeck.vs": 1.0}
SUBSTEPS = 20


@cache
def made() -> tuple[Record, ...]:
    """Records with a Stribeck effect; those of the fit have a drift of the torque as well, the other has none."""
    drifting = records(STRIBECK | {"motor.constant_torque.tau0": 0.01})
    return (*drifting[:2], records(STRIBECK)[2])


@cache
def before() -> FitResult:
    return fitted(list(made()))


@cache
def extended(*effects: str) -> Extension:
    return extend(ExtensionTask(before(), made(), [STRIBECK]), effects)


def stepped(values: dict[str, float], record: Record) -> Array:
    """Speed of the axis under the recorded torque, from rest, friction as a set-valued law in small steps (Moreau
    1988), (n,)."""
    J, fv, fc = (values[name] for name in TRUTH)
    dfs, vs = values.get("motor.stribeck.dFs", 0.0), values.get("motor.stribeck.vs", 1.0)
    dt, v, found = SAMPLING_TIME / SUBSTEPS, 0.0, []
    for torque in record.tau_m.tolist():
        found.append(v)
        for _ in range(SUBSTEPS):
            most = dt * (fc + dfs * np.exp(-((v / vs) ** 2))) / J
            free = v + dt * (torque - fv * v) / J
            v = 0.0 if abs(free) <= most else free - np.sign(free) * most
    return np.array(found)


def values_of(fit: FitResult) -> dict[str, float]:
    return {p.name: p.value for p in fit.parameters}


def test_before_and_after_are_told_of_every_record() -> None:
    e = extended("motor.stribeck")
    assert set(e.before) == set(e.after) == {"slow", "wide", "check"}
    assert {name: score.used for name, score in e.after.items()} == {"slow": True, "wide": True, "check": False}
    assert {name: score.role for name, score in e.before.items()}["check"] == "validate"
    assert set(e.model_after) - set(e.model_before) == {"motor.stribeck"}
    assert (e.added, e.dropped) == (("motor.stribeck",), ())


@pytest.mark.parametrize("record", [0, 2], ids=["slow", "check"])
def test_the_gain_is_that_of_a_simulation_in_small_steps(record: int) -> None:
    e, r = extended("motor.stribeck"), made()[record]
    percent = [fit_percent(r.dphi_m, stepped(values_of(fit), r)) for fit in (before(), e.fit)]
    # first order in the step, and from rest rather than from the first state that fits best
    assert e.before[r.name].fit_percent == pytest.approx(percent[0], abs=0.3)
    assert e.after[r.name].fit_percent == pytest.approx(percent[1], abs=0.3)
    assert percent[1] - percent[0] > 1.0


def test_what_is_held_keeps_its_value_while_the_rest_is_fitted() -> None:
    held = {"motor.stribeck.dFs": 0.1, "motor.stribeck.vs": 1.2}
    task = ExtensionTask(before(), made(), [STRIBECK], held=held)
    after = task.fit_with(["motor.stribeck"])
    assert {name: values_of(after)[name] for name in held} == held
    assert [p.name for p in after.parameters if p.fixed] == list(held)
    assert all(values_of(after)[name] != values_of(before())[name] for name in TRUTH)
    assert values_of(task.fit_with(["motor.constant_torque"])).keys() == {*TRUTH, "motor.constant_torque.tau0"}


def test_a_cause_beside_a_curve_keeps_what_it_is_there() -> None:
    plain = replace(NAMED, causes=(CAUSE,), events=(), late=0.0)
    beside = replace(plain, beside_shape=True)
    tasks = [extension_task(diagnosis, before(), made()) for diagnosis in (plain, beside)]
    assert [task.held for task in tasks] == [{}, {p.name: p.value for p in CAUSE.parameters}]
    assert with_gains(plain, tasks[0]).causes[0].parameters != CAUSE.parameters
    assert with_gains(beside, tasks[1]) is beside


def test_without_held_out_records_a_cause_has_the_parameters_of_a_fit_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of the search are weighed by a noise that may be none of the machine's."""
    plain = replace(NAMED, causes=(CAUSE,), events=(), late=0.0)
    fitted_ones = [record for record in made() if record.name in before().records]
    task = extension_task(plain, before(), fitted_ones)
    (cause,) = with_gains(plain, task).causes
    assert np.isnan(cause.heldout_gain)
    assert cause.parameters != CAUSE.parameters

    def no_end(*_: Any) -> Any:
        raise NumericsError("the fit does not converge")

    monkeypatch.setattr(ExtensionTask, "fit_with", no_end)
    kept = with_gains(plain, task)
    assert kept.causes == plain.causes
    assert "comes to an end" in kept.remarks[-1]


def test_a_fit_of_the_diagnosis_is_taken_over_where_it_is_of_the_same_effects(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = replace(NAMED, causes=(CAUSE,), events=(), late=0.0)
    task = extension_task(plain, before(), made())
    known = with_gains(plain, task).extended
    assert known is not None
    assert values_of(known) == values_of(task.fit_with(["motor.stribeck"]))
    knowing = replace(task, known=known)
    assert knowing.fit_with(["motor.stribeck", "motor.constant_torque"]) is not known
    monkeypatch.setattr(fits, "fit_model", None)
    assert extend(knowing, ["motor.stribeck"]).fit.parameters == known.parameters


def test_where_no_cause_is_confirmed_no_fit_is_kept() -> None:
    task = extension_task(NAMED, before(), made())
    strict = Criteria(significance=0.0)
    judged = with_gains(replace(NAMED, causes=(CAUSE,)), task, strict)
    assert (judged.causes, judged.extended) == ((), None)


def test_the_criterion_falls_with_a_true_cause() -> None:
    e = extended("motor.stribeck")
    assert e.bic_after < e.bic_before - 100
    n = {r.name: len(r) for r in made()[:2]}
    gained = sum(n[name] * ((e.before[name].rmse / e.after[name].rmse) ** 2 - 1) for name in n)
    assert e.bic_before - e.bic_after == pytest.approx(gained - 2 * np.log(sum(n.values())), rel=1e-6)


def test_a_cause_that_does_not_carry_over_is_dropped_beside_one_that_does() -> None:
    e = extended("motor.stribeck", "motor.constant_torque")
    assert e.added == ("motor.stribeck",)
    (dropped,) = e.dropped
    assert all(np.isfinite(p.std_robust) for p in e.fit.parameters if not p.fixed)
    assert (dropped.effect, "held-out" in dropped.why) == ("motor.constant_torque", True)
    assert dropped.heldout_gain < 0.0
    assert e.model_after == extended("motor.stribeck").model_after
    assert e.after["check"].fit_percent == pytest.approx(
        extended("motor.stribeck").after["check"].fit_percent, abs=0.01
    )


def test_a_single_cause_that_does_not_carry_over_leaves_the_model_as_it_was() -> None:
    e = extended("motor.constant_torque")
    assert (e.added, e.model_after) == ((), e.model_before)
    (dropped,) = e.dropped
    assert dropped.heldout_gain < 0.0
    assert dropped.why.startswith("does not carry over")
    assert {name: s.rmse for name, s in e.after.items()} == {name: s.rmse for name, s in e.before.items()}
    assert e.bic_after == e.bic_before
    assert e.fit is before()


def test_a_record_that_cannot_be_simulated_speaks_against_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    simulated = fits.simulate_record

    def diverging(model: FittedModel, record: Record, horizon: float | None) -> Simulated:
        if record.name == "check" and "motor.constant_torque" not in model.joint.structure.effects:
            raise NumericsError("the simulation diverges")
        return simulated(model, record, horizon)

    monkeypatch.setattr(fits, "simulate_record", diverging)
    task = ExtensionTask(before(), made(), [STRIBECK])
    e = extend(task, ("motor.constant_torque", "motor.stribeck"))
    assert (e.added, e.dropped) == (("motor.constant_torque", "motor.stribeck"), ())
    assert "check" not in e.before
    assert np.isnan(gains(task, ("motor.constant_torque",))[0]).all()


def test_a_record_that_no_model_simulates_tells_nothing_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither of a cause, which it does not refute, nor of the others on the records that are simulated."""
    simulated = fits.simulate_record

    def diverging(model: FittedModel, record: Record, horizon: float | None) -> Simulated:
        if record.name == "lost":
            raise NumericsError("the simulation diverges")
        return simulated(model, record, horizon)

    monkeypatch.setattr(fits, "simulate_record", diverging)
    lost = replace(made()[2], name="lost")
    with_it, alone = (
        ExtensionTask(before(), (*made()[:2], *more), [STRIBECK]) for more in ((made()[2], lost), (lost,))
    )
    e = extend(with_it, ("motor.constant_torque", "motor.stribeck"))
    assert (e.added, [one.effect for one in e.dropped]) == (("motor.stribeck",), ["motor.constant_torque"])
    assert gains(with_it, ("motor.stribeck",))[0][0] > 1.0
    assert extend(alone, ("motor.stribeck",)).added == ("motor.stribeck",)
    assert np.isnan(gains(alone, ("motor.stribeck",))[0]).all()


def test_what_no_fit_can_be_without_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    fit_model = fits.fit_model

    def failing(name: str, joint: Joint, *rest: Any, **options: Any) -> FitResult:
        if "motor.constant_torque" not in joint.structure.effects:
            raise NumericsError("the derivatives are not finite")
        return fit_model(name, joint, *rest, **options)

    monkeypatch.setattr(fits, "fit_model", failing)
    task = ExtensionTask(before(), made(), [STRIBECK])
    e = extend(task, ("motor.constant_torque", "motor.stribeck"))
    assert (e.added, e.dropped) == (("motor.constant_torque", "motor.stribeck"), ())
    assert np.isnan(gains(task, ("motor.constant_torque", "motor.stribeck"))[0][0])


def test_without_records_held_out_nothing_is_dropped() -> None:
    e = extend(ExtensionTask(before(), made()[:2], [{}]), ("motor.constant_torque",))
    assert (e.added, e.dropped) == (("motor.constant_torque",), ())
    assert values_of(e.fit)["motor.constant_torque.tau0"] == pytest.approx(0.01, rel=0.3)


def test_a_gain_is_the_one_that_the_extension_measures_and_comes_cause_by_cause() -> None:
    task = ExtensionTask(before(), made(), [STRIBECK])
    whole = extended("motor.stribeck")
    (alone,), _ = gains(task, ("motor.stribeck",))
    held = [name for name, score in whole.after.items() if not score.used]
    measured = np.mean([whole.after[n].fit_percent - whole.before[n].fit_percent for n in held])
    assert alone == pytest.approx(float(measured))
    (first, second), last = gains(task, ("motor.stribeck", "motor.constant_torque"))
    assert first == pytest.approx(alone)
    assert second < 0.05 * first
    assert last is not None
    assert last.structure.effects[-2:] == ("motor.stribeck", "motor.constant_torque")
    assert gains(task, ()) == ([], None)


def test_an_effect_that_was_not_diagnosed_leaves_a_fit_that_went_astray() -> None:
    locked = tuple(replace(p, value=50.0 * p.value if "coulomb" in p.name else p.value) for p in before().parameters)
    astray = replace(before(), parameters=locked, start=dict(TRUTH))
    found = ExtensionTask(astray, made()).fit_with(["motor.stribeck"])
    named = ExtensionTask(before(), made(), [STRIBECK]).fit_with(["motor.stribeck"])
    assert found.misfit == pytest.approx(named.misfit, rel=1e-3)


def test_an_effect_that_was_not_diagnosed_starts_at_what_its_score_promises() -> None:
    small = [replace(record, tau_m=1e-3 * record.tau_m) for record in made()]  # what it is by default would lock it
    found = ExtensionTask(fitted(small), small).fit_with(["motor.stribeck"])
    named = ExtensionTask(before(), made(), [STRIBECK]).fit_with(["motor.stribeck"])
    assert found.misfit == pytest.approx(named.misfit, rel=0.01)


def test_of_an_effect_that_is_there_no_score_promises_anything() -> None:
    assert scored_starts(fitted_model(before()), made()[:2], ["motor.coulomb"], None) == []
