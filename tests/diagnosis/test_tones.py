"""A tone in the recorded torque that the motion does not show is no cause: it is found, told and taken out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from support.small_bench import DURATION, SAMPLING_TIME, fitted, made_along, records, simulated

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.procedure import diagnose
from robotid.diagnosis.results import Tone
from robotid.diagnosis.tones import MOST, as_remarks, tones, without_tones
from robotid.model.array import Array
from robotid.signals.record import Record


def humming(made: Sequence[Record], amplitude: float, frequency: float = 39.1) -> list[Record]:
    """Records whose log holds a tone that their motor does not."""
    return [replace(one, tau_m=one.tau_m + hum(one, amplitude, frequency)) for one in made]


def hum(record: Record, amplitude: float, frequency: float) -> Array:
    return np.asarray(amplitude * np.sin(2 * np.pi * frequency * record.t + 0.3))


def heard(made: list[Record]) -> list[Tone]:
    return [tone for run in simulated(made) for tone in tones(run, "speed")]


def compensated(periods: float, amplitude: float = 0.1) -> list[Record]:
    """Records at one speed each, of a cogging whose torque the controller gives so well that no speed shows it."""
    t = np.arange(round(DURATION / SAMPLING_TIME)) * SAMPLING_TIME
    wanted = {"slow": np.clip(40 * t, 0, 8.0), "wide": np.clip(40 * t, 0, 16.0), "check": np.where(t < 2, 8.0, -8.0)}
    return [replace(one, tau_m=one.tau_m + amplitude * np.cos(periods * one.phi_m)) for one in made_along(wanted)]


@pytest.mark.parametrize(("amplitude", "frequency"), [(0.03, 39.1), (0.1, 120.0)])
def test_a_hum_of_the_log_is_found_in_every_record_with_its_size(amplitude: float, frequency: float) -> None:
    found = heard(humming(records({}), amplitude, frequency))
    assert sorted(one.record for one in found) == ["check", "slow", "wide"]
    for one in found:
        assert one.frequency == pytest.approx(frequency, abs=0.1 / DURATION * 2)
        assert one.amplitude == pytest.approx(amplitude, rel=0.1)


def test_without_it_the_torque_is_that_of_the_motor() -> None:
    made = records({})
    left = [without_tones(one, heard(humming(made, 0.1))) for one in humming(made, 0.1)]
    for one, true in zip(left, made, strict=True):
        assert np.std(one.tau_m - true.tau_m) < 0.1 * np.std(hum(true, 0.1, 39.1))
    other = replace(made[0], name="other")
    assert without_tones(other, heard(humming(made, 0.1))) is other


def test_a_stretch_has_the_tone_of_its_own_time_alone() -> None:
    record = records({})[0]
    tone = Tone(record.name, 1.0, 2.0, 50.0, 0.1, 0.0)
    changed = record.tau_m - without_tones(record, [tone]).tau_m
    within = (record.t >= 1.0) & (record.t <= 2.0)
    assert changed[~within].tolist() == [0.0] * int(np.sum(~within))
    assert changed[within] == pytest.approx(0.1 * np.cos(2 * np.pi * 50.0 * record.t[within]))
    piece = record.piece(600, 700)
    assert piece.tau_m - without_tones(piece, [tone]).tau_m == pytest.approx(changed[600:700])


def test_clean_records_hold_none() -> None:
    assert [one for seed in range(1, 13) for one in heard(records({}, seed=seed))] == []


@pytest.mark.parametrize("periods", [12.0, 36.0])
@pytest.mark.parametrize("peaks", [1.0, 30.0])
def test_what_follows_the_angle_is_none_though_a_constant_speed_makes_it_one_in_time(
    periods: float, peaks: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The derivative of an angle with few counts has peaks of many times the speed."""
    runs = []
    for run in simulated(compensated(periods)):
        speed = run.record.dphi_m.copy()
        speed[::100] *= peaks
        runs.append(replace(run, record=replace(run.record, dphi_m=speed)))
    assert [tone for run in runs for tone in tones(run, "speed")] == []
    monkeypatch.setattr("robotid.diagnosis.tones._follows_the_angle", lambda *_: False)
    assert {tone.record for run in runs for tone in tones(run, "speed")} >= {"slow", "wide"}


@pytest.mark.parametrize(("beside", "found"), [(41.0, False), (52.0, True)])
def test_a_line_among_others_that_move_the_joint_is_one_of_these(beside: float, found: bool) -> None:
    """Of a torque that repeats with the motion, one line may hardly move a motor whose arm absorbs it."""
    driven = [
        replace(one, tau_m=one.tau_m + hum(one, 0.1, beside), dphi_m=one.dphi_m + hum(one, 0.5, beside))
        for one in humming(records({}), 0.1)
    ]
    assert bool([one for one in heard(driven) if one.frequency == pytest.approx(39.1, abs=0.3)]) is found


def test_what_has_few_periods_is_no_tone() -> None:
    assert heard(humming(records({}), 0.2, 3.0)) == []


def test_so_many_are_taken_out_and_told_by_frequency() -> None:
    made = records({})
    for k in range(MOST + 2):
        made = humming(made, 0.2, 60.0 + 17.3 * k)
    found = heard(made)
    assert len([one for one in found if one.record == "slow"]) == MOST
    sentences = list(as_remarks(humming_of("a", "b"), "Nm"))
    assert len(sentences) == 2
    assert sentences[0].startswith("the torque of a and b holds a tone of 50 Hz, up to 0.2 Nm, ")


def humming_of(*names: str) -> list[Tone]:
    return [Tone(one, 0.0, 1.0, 50.0 + 0.1 * k, 0.0, 0.1 + 0.1 * k) for k, one in enumerate(names)] + [
        Tone("b", 0.0, 1.0, 100.0, 0.0, 0.1)
    ]


def test_a_short_record_is_not_asked() -> None:
    run = simulated(humming(records({}), 0.1))[0]
    short = replace(run, record=run.record.piece(0, 50))
    assert list(tones(short, "speed")) == []


def test_a_diagnosis_beside_a_hum_is_that_of_the_machine() -> None:
    made = humming(records({}), 0.1)
    said: list[str] = []
    found = diagnose(fitted(made), made, Criteria(skip=("record_change", "power_friction")), log=said.append)
    assert found.verdict == "clean"
    assert {one.record for one in found.tones} == {"slow", "wide", "check"}
    assert any("holds a tone of 39.1 Hz" in remark for remark in found.remarks)
    assert {remark for remark in found.remarks if "holds a tone" in remark} <= set(said)
