"""The answer in one paragraph, whatever has run."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.diagnosed import CLEAN, NAMED, UNKNOWN
from support.report_findings import findings, with_events

from robotid.diagnosis.remarks import SHAPELESS, UNEXPLAINED
from robotid.diagnosis.results import Misfit
from robotid.estimate.result import End
from robotid.report.findings import Findings
from robotid.report.summary import remarks, summary
from robotid.validation.results import Identifiability


def told(**changes: object) -> str:
    return summary(replace(findings(), **changes))


STAGES = ("excitation", "recordings", "rigid", "flex", "fits", "validation", "diagnosis", "extension")


def before(stage: str) -> dict[str, None]:
    """Nothing of a stage and those after it."""
    return dict.fromkeys(STAGES[STAGES.index(stage) :])


@pytest.mark.parametrize(
    ("missing", "expected"),
    [
        (
            before("recordings"),
            "2 reference signals for irb are ready; nothing has been recorded yet.",
        ),
        (before("rigid"), "2 records of irb, 3 s in all, are ready. No model has been fitted yet."),
        (
            before("flex"),
            "As a rigid joint irb has joint.inertia.J = 0.0346 kg m2; the torque is met to 3.5 %."
            " No model has been fitted by simulation yet.",
        ),
        (
            before("fits"),
            "2 frequency responses of irb were measured, with a notch at 5.71 Hz. They give gear.spring.k1 ="
            " 1.46·10⁶ Nm/rad; no model has been fitted by simulation yet.",
        ),
        (
            before("validation"),
            "Model m of irb was fitted to small and simulates the motor speed there with a fit of 100.00 %. It has not"
            " been validated yet.",
        ),
        (
            before("diagnosis"),
            "Model m of irb simulates the motor speed with a fit of 100.00 % (small) on the records it was fitted to"
            " and 100.00 % (large) on held-out records.",
        ),
    ],
)
def test_as_far_as_the_stages_have_come(missing: dict[str, None], expected: str) -> None:
    assert told(**missing) == expected


def test_the_whole_story() -> None:
    text = told()
    for sentence in (
        "Beyond noise of 0.01 rad/s it is wrong by 0.13 rad/s RMS; the torque that it lacks follows the motor speed"
        " best, counted along the motion.",
        "The causes are motor.stribeck (torque missing at small speed only; explains 97 %) and arm.inertia.J (differs"
        " in large by 12 kg m2; explains 2 % of large).",
        "In small there is a torque of 0.3 Nm from 1.7 to 2.5 s: an event, not a property of the machine.",
        "In small there is friction that is larger by 0.16 Nm from 2.2 s on: an event, not a property of the machine.",
        "These data cannot tell motor.stribeck from motor.presliding; an experiment that would is given below.",
        "Together they leave 0.011 rad/s beyond the noise (3 % of the misfit's energy, weighed by the noise).",
        "With motor.stribeck added, the fit of held-out record large goes from 95.00 to 99.20 % (its RMS error falls by"
        " 95 %).",
        "Dropped in the final fit, for it no longer earned its place: motor.cogging.",
    ):
        assert sentence in text
    assert text.count("Model m of irb") == 1


def test_a_fit_with_an_event_in_the_record_is_told_from_that_which_accounts_for_it() -> None:
    text = summary(with_events())
    assert "100.00 % (small, its events not accounted for) on the records it was fitted to" in text
    assert "With them accounted for, m simulates small to 96.10 %; its extension is compared with this fit." in text
    one = with_events()
    event = one.diagnosis.events[0]
    one = replace(
        one,
        diagnosis=replace(one.diagnosis, events=(event,)),
        extension=replace(one.extension, events=(event,)),
    )
    assert "(small, its event not accounted for)" in summary(one)
    assert "With it accounted for, m simulates small" in summary(one)
    calm = replace(one, diagnosis=replace(one.diagnosis, events=()), extension=replace(one.extension, events=()))
    assert "accounted" not in summary(calm)


def test_clean_and_unknown_are_answers() -> None:
    clean = told(diagnosis=CLEAN, extension=replace(findings().extension, added=()))
    assert "What it leaves is noise of 0.01 rad/s RMS: there is nothing else to explain." in clean
    slow = told(diagnosis=replace(CLEAN, torque_errors=0.162), extension=None)
    sized = (
        "What it leaves is 0.01 rad/s RMS, no more than errors of the torque of 0.16 Nm would: nothing stands out of"
    )
    assert sized in slow
    assert "nothing else to explain" not in slow
    assert clean.endswith("stands in the table of limits; gear.backlash cannot be seen in them at all.")
    unknown = told(diagnosis=UNKNOWN, extension=None)
    assert "No effect of the catalogue explains it, so the cause is unknown;" in unknown
    assert unknown.endswith("what is missing follows the motor angle best.")


def test_what_causes_leave_beside_errors_of_the_torque_is_no_share() -> None:
    text = told(diagnosis=replace(findings().diagnosis, torque_errors=0.162, remaining_share=0.0))
    expected = "Together they leave 0.011 rad/s beyond the noise, no more than errors of the torque of 0.16 Nm would."
    assert expected in text


def test_a_held_out_record_that_is_simulated_far_worse_is_told_of() -> None:
    for misfit, expected in ((2.5, True), (1.5, False)):
        worse = {
            name: replace(m, misfit=misfit * UNKNOWN.misfit) if m.role == "validate" else m
            for name, m in UNKNOWN.records.items()
        }
        assert any(m.role == "validate" for m in worse.values())
        text = told(diagnosis=replace(UNKNOWN, records=worse), extension=None)
        assert ("held out of the fit, it is wrong by" in text) == expected


def test_the_curve_beside_which_a_cause_was_found_is_told_with_how_it_counts() -> None:
    assert UNKNOWN.shape is not None
    beside = replace(NAMED, shape=replace(UNKNOWN.shape, along="phi_m, by twist"), beside_shape=True)
    sentence = "it follows the motor angle best, counted in proportion to gear twist."
    assert f"What is left is no effect of the catalogue; {sentence}" in told(diagnosis=beside)
    assert sentence not in told(diagnosis=replace(beside, shape=None, beside_shape=False))


def test_what_the_causes_leave_is_told_where_it_is_something() -> None:
    d = findings().diagnosis
    assert "Together they leave nothing beyond the noise." in told(diagnosis=replace(d, remaining=0.0))
    assert "Together they leave" not in told(diagnosis=replace(d, remaining=2 * d.misfit))


def test_pieces_are_told_where_a_fit_simulates_them() -> None:
    assert "With motor.stribeck added, simulated in pieces of 2.5 s, the fit of" in told(horizon=2.5)
    assert "The fit and the diagnosis simulate pieces of 2.5 s, each from a first state of its own" in told(horizon=2.5)
    assert "pieces" not in told()


def test_pieces_that_a_diagnosis_alone_takes_are_told_to_be_its_own() -> None:
    f = findings()
    assert f.diagnosis is not None
    text = told(diagnosis=replace(f.diagnosis, horizon=0.25))
    assert "The diagnosis simulates pieces of 0.25 s, each from a first state of its own; the fits in its" in text
    assert "added, simulated in pieces of 0.25 s, the fit of" in text


def test_nothing_held_out_is_said() -> None:
    f = findings()
    best = f.validation.models["m"]
    only = replace(f.validation, models={"m": replace(best, records={"small": best.records["small"]})})
    e = f.extension
    fitted = replace(e, before={"small": e.before["small"]}, after={"small": e.after["small"]})
    text = told(validation=only, extension=fitted)
    assert "No record was held out, so this does not tell how well it does on motions it has not seen." in text
    assert text.count("No record was held out") == 2
    assert "the fit of small goes from 96.10 to 99.80 %" in text


def test_many_records_are_told_as_a_range() -> None:
    f = findings()
    best = f.validation.models["m"]
    record = best.records["small"]
    many = {f"r{k}": replace(record, fit_percent=90.0 + k) for k in range(5)}
    text = told(validation=replace(f.validation, models={"m": replace(best, records=many)}))
    assert "a fit of 90.00 to 94.00 % on the records it was fitted to." in text
    pushed = replace(f.diagnosis, events=tuple(replace(event, record="r1") for event in f.diagnosis.events))
    text = told(validation=replace(f.validation, models={"m": replace(best, records=many)}), diagnosis=pushed)
    assert "a fit of 90.00 to 94.00 % (events in r1 not accounted for) on the records" in text


def test_what_the_configuration_demands_and_a_model_that_diverges() -> None:
    f = findings()
    failed = replace(f.validation, failed=("m fits large to 80.00 %, below the 98 % asked",))
    assert "That is not enough: m fits large to 80.00 %, below the 98 % asked." in told(validation=failed)
    nowhere = replace(f.validation, models={"m": replace(f.validation.models["m"], records={})})
    assert "nothing: it diverges on every record" in told(validation=nowhere)


def test_a_sliding_axis_has_its_own_units() -> None:
    assert "1.46·10⁶ N/m" in told(linear=True, **before("fits"))
    assert summary(Findings("irb")) == ""


def test_doubts_of_the_fit_stand_beside_the_answer() -> None:
    fits = findings().fits
    assert fits is not None
    doubtful = replace(fits.models[fits.best], remarks=("motor.coulomb.Fc ended at its lower bound, 0",))
    f = replace(findings(), fits=replace(fits, models=fits.models | {fits.best: doubtful}))
    assert remarks(f) == ("motor.coulomb.Fc ended at its lower bound, 0.", *remarks(findings()))
    assert summary(f) == told()
    assert remarks(Findings("irb")) == ()


@pytest.mark.parametrize(
    ("remark", "stands"), [("the budget of 3 s is spent", True), (SHAPELESS, False), (UNEXPLAINED, False)]
)
def test_doubts_of_the_diagnosis_stand_there_too_unless_the_answer_tells_them(remark: str, stands: bool) -> None:
    found = findings().diagnosis
    assert found is not None
    f = replace(findings(), diagnosis=replace(found, remarks=(remark,)))
    assert (f"{remark[0].upper()}{remark[1:]}." in remarks(f)) is stands


def test_a_fit_that_did_not_converge_is_told() -> None:
    f = findings()
    stalled = {"m": replace(f.fits.models["m"], end=End.STALLED)}
    assert "The fit of m stalled: no step lowers the cost any further" in told(fits=replace(f.fits, models=stalled))
    assert "stalled" not in told()
    both = replace(f.extension, fit=replace(f.extension.fit, end=End.STALLED))
    text = told(fits=replace(f.fits, models=stalled), extension=both)
    assert "The fits of m and the extended m stalled: no step" in text
    assert text.count("stalled") == 1


def test_what_errors_of_the_other_torques_would_hide_is_not_called_undetermined() -> None:
    f = findings()
    best = f.validation.models["m"]
    small = Identifiability("gear.cubic_spring.k3", "unseen", "", relative_std=0.009, torque_share=0.011)
    noisy = Identifiability("gear.damper.d", "unseen", "", relative_std=2.0, torque_share=0.011)

    def about(*found: Identifiability) -> str:
        models = {"m": replace(best, identifiability=found)}
        return told(validation=replace(f.validation, models=models))

    text = about(small, noisy)
    assert "These records do not determine gear.damper.d." in text
    assert "These records determine gear.cubic_spring.k3 only if the other torques are right to 2 %." in text
    assert "do not determine" not in about(small)


def test_a_torque_that_was_moved_in_time_is_told_before_its_diagnosis() -> None:
    text = told(diagnosis=replace(CLEAN, late=0.0012))
    said = "The torque is recorded 1.2 ms late, within what clocks explain: moved by as much before causes"
    assert 0 < text.index(said) < text.index("What it leaves is noise")
    assert said not in told(diagnosis=CLEAN)


def test_a_clean_verdict_is_not_claimed_for_records_that_the_model_gets_wrong() -> None:
    said = "On large, held out of the fit, it is wrong by 0.6 rad/s RMS beyond the noise"
    records = {
        "small": Misfit("estimate", 99.0, 0.02, 0.02, 0.0, 0.0),
        "large": Misfit("validate", 95.0, 0.6, 0.01, 0.6, 0.0),
    }
    assert said in told(diagnosis=replace(CLEAN, records=records))
    records["large"] = replace(records["large"], misfit=0.005)
    assert "held out of the fit" not in told(diagnosis=replace(CLEAN, records=records))


def test_held_out_records_that_no_parameters_simulate_are_said_to_lack_something() -> None:
    records = {
        "small": Misfit("estimate", 99.0, 0.02, 0.02, 0.0, 0.0),
        "large": Misfit("validate", 95.0, 0.6, 0.01, 0.6, 0.0),
    }
    text = told(diagnosis=replace(CLEAN, verdict="unknown", records=records, apart=("large",)))
    assert "On large, held out of the fit, it is wrong by 0.6 rad/s RMS beyond the noise" in text
    assert "No parameters simulate both, so that something is missing: fit these records, too" in text
    assert "nothing else to explain" not in text
