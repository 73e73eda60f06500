"""Whether errors of the torque are all that a model leaves, and most of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.plain_models import SAMPLES, plain_data, plain_model

from robotid.diagnosis.search.state import AcceptedCause, RejectedCause, SearchResult
from robotid.diagnosis.search.torque_errors import lead_astray, leaves_only_noise, prevail, strays


def found(energy: float, *, reached: bool = True) -> SearchResult:
    """Of a model that leaves this energy beside a noise of the output of unit variance, at rest."""
    model, data = plain_model(energy), plain_data()
    coloured = replace(data, noise_reached=reached)
    return SearchResult(data, model, model, (), (), (), coloured=coloured)


@pytest.mark.parametrize(("times", "most"), [(1.0, False), (1.9, False), (2.1, True)])
def test_they_prevail_where_they_cause_more_than_the_noise_of_the_output(times: float, most: bool) -> None:
    assert prevail(found(times * SAMPLES)) is most


def test_what_no_noise_explains_or_what_it_hides_is_not_only_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = found(1.0)
    monkeypatch.setattr("robotid.diagnosis.search.torque_errors.is_swamped", lambda _: False)
    assert leaves_only_noise(seen)
    assert not leaves_only_noise(found(1.0, reached=False))
    assert not leaves_only_noise(replace(seen, coloured=None))
    monkeypatch.setattr("robotid.diagnosis.search.torque_errors.is_swamped", lambda _: True)
    assert not leaves_only_noise(seen)


def test_what_acts_like_an_effect_that_makes_no_sense_is_not_only_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = found(1.0)
    monkeypatch.setattr("robotid.diagnosis.search.torque_errors.is_swamped", lambda _: False)
    rejected = RejectedCause("motor.thermal_friction", 1.0, 10.0, "makes no sense")
    assert leaves_only_noise(replace(seen, rejected=(rejected,)))
    assert not leaves_only_noise(replace(seen, rejected=(replace(rejected, imitates=True),)))


def moving(share: float) -> SearchResult:
    """Off the motion by this share of its variance, beyond the noise."""
    seen = found(1.0)
    (one,) = seen.last.fitted
    record = replace(one.record, dphi_m=200.0 * np.sin(one.record.t))
    off = np.full(len(one.residual), np.sqrt(share) * float(np.std(record.dphi_m)))
    return replace(seen, last=replace(seen.last, fitted=(replace(one, record=record, residual=off),)))


def test_what_nothing_known_explains_leads_a_simulation_astray_as_errors_of_the_torque_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    far, curve = replace(moving(0.02), coloured=None), object()
    assert not leaves_only_noise(far)
    assert lead_astray(far)
    assert not lead_astray(replace(far, curve=curve))  # type: ignore[arg-type]
    assert not lead_astray(replace(far, causes=causes(0.49)))
    assert not lead_astray(replace(moving(5e-4), coloured=None))
    monkeypatch.setattr("robotid.diagnosis.search.torque_errors.leaves_only_noise", lambda _: True)
    assert lead_astray(replace(far, causes=causes(0.49)))


def test_causes_that_explain_most_and_yet_leave_the_simulation_far_off_may_only_imitate() -> None:
    far = replace(moving(0.02), coloured=None)
    assert lead_astray(replace(far, causes=causes(0.3, 0.21)))
    assert not lead_astray(replace(moving(5e-4), coloured=None, causes=causes(0.51)))


def causes(*explained: float) -> tuple[AcceptedCause, ...]:
    """Causes that explain these shares of a misfit."""
    model = plain_model(1.0)
    name = "motor.stribeck"
    return tuple(AcceptedCause(name, share, 1.0, 1e-9, (name,), model, model, None) for share in explained)


def test_a_simulation_strays_by_what_it_leaves_itself() -> None:
    far = moving(0.02)
    (one,) = far.last.fitted
    assert strays(far)
    assert not strays(far, [0.1 * one.residual])
    assert strays(moving(0.0), [one.residual])
