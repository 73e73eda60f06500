"""What is printed of a diagnosis and an extension: the JSON of docs/command-line.md, and all that matters in tables."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.diagnosed import CLEAN, EXTENSION, NAMED, PAYLOAD, PUSH, UNKNOWN

from robotid.cli.console import print_json, print_tables
from robotid.diagnosis.results import Diagnosis, Separation
from robotid.report.tables import diagnose, extend
from robotid.report.tables.table import Table


def printed(document: Any, capsys: pytest.CaptureFixture[str]) -> Any:
    print_json(document)
    out = capsys.readouterr().out
    assert "NaN" not in out
    return json.loads(out)


def shown(tables: tuple[Table, ...], capsys: pytest.CaptureFixture[str]) -> str:
    print_tables(tables)
    out = capsys.readouterr().out
    assert "nan" not in out
    return out


def test_a_named_cause_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    found = printed(diagnose.document(NAMED), capsys)
    assert (found["verdict"], found["noise_floor"], found["misfit"], found["unit"], found["remaining"]) == (
        "named",
        0.01,
        0.13,
        "rad/s",
        0.011,
    )
    first, second = found["causes"]
    assert first["effect"] == "motor.stribeck"
    assert first["parameters"]["dFs"] == {"value": 0.2, "std": 0.01, "std_robust": 0.02, "unit": "Nm"}
    assert (first["explained"], first["heldout_gain"], first["p_value"]) == (0.97, 4.2, 1e-12)
    assert first["class"] == ["motor.stribeck", "motor.presliding"]
    assert first["separate_by"]["excite"] == {"kind": "triangle", "amplitude": 5, "period": 2}
    assert "separate_by" not in second
    assert second["heldout_gain"] is None
    assert list(second["parameters"]) == ["record_change.day2.arm.inertia.J"]
    assert first["confounded_with"] == [{"effect": "motor.quadratic_friction", "correlation": 0.92}]
    assert "explained_of" not in first
    assert second["explained_of"] == "day2"
    assert found["remaining_share"] == 0.03
    assert found["limits"] == {"gear.backlash": None, "motor.cogging": {"A": 0.0075, "unit": "Nm"}}
    push, step = found["events"]
    assert (push["record"], push["kind"], push["of"], push["from"], push["to"]) == ("set1", "bump", "torque", 1.7, 2.5)
    assert (push["torque"], push["std"], push["p_value"]) == (0.3, 0.01, 1e-20)
    assert (step["kind"], step["of"]) == ("step", "friction")
    assert found["rejected"][0] == {
        "effect": "motor.cogging",
        "explained": 0.05,
        "heldout_gain": None,
        "why": "p = 0.4",
    }
    assert found["shape"] is None
    assert found["records"]["check"]["role"] == "validate"
    assert [place["along"] for place in found["where"]] == ["dphi_m", "record"]


def test_the_shape_of_what_is_unknown(capsys: pytest.CaptureFixture[str]) -> None:
    shape = printed(diagnose.document(UNKNOWN), capsys)["shape"]
    assert (shape["along"], shape["unit"]) == ("phi_m", "Nm")
    assert len(shape["x"]) == len(shape["missing_torque"]) == 30
    assert shape["missing_torque"][2] is None
    text = shown(diagnose.tables(UNKNOWN), capsys)
    assert "Shape of what is unknown" in text
    assert "motor angle [rad]" in text


def test_a_block_may_be_that_of_a_whole_record(capsys: pytest.CaptureFixture[str]) -> None:
    cause = replace(PAYLOAD, separation=Separation("x", '{"excite": {"kind": "square"}}', 2.0))
    found = printed(diagnose.document(replace(NAMED, causes=(cause,))), capsys)
    assert found["causes"][0]["separate_by"]["excite"] == {"kind": "square"}


def test_all_that_matters_is_in_the_tables(capsys: pytest.CaptureFixture[str]) -> None:
    text = shown(diagnose.tables(NAMED), capsys)
    for fact in ("named", "set1", "check", "motor.stribeck", "97.0", "4.20", "1e-12", "motor.presliding", "0.83"):
        assert fact.removeprefix("0.") in text
    assert 'excite: {"kind": "triangle", "amplitude": 5, "period": 2}' in text
    assert "motor.stribeck or motor.presliding? excite:" in text
    assert "worse on held-out records" in text
    assert "motor.quadratic_friction 0.92" in text
    assert "bump of torque" in text
    assert "step of friction" in text
    assert "invisible in these records: gear.backlash" in text
    assert "the records are short" in text
    assert "-0.2" in text or "0.2" in text


def test_where_the_misfit_sits_is_said_in_words() -> None:
    speed, of_record = NAMED.curves
    twist = replace(speed, along="twist, by direction", unit="rad", order=0.3)
    little = replace(speed, along="phi_m", unit="rad", order=0.01)
    first = replace(of_record, x=np.array([0.0, 1.0]), missing_torque=np.array([0.0, 0.1]))
    found = diagnose.tables(replace(NAMED, curves=(speed, first, twist, little)))
    (table,) = [one for one in found if one.title == "Where the misfit sits"]
    assert [row[:3] for row in table.rows] == [
        ("motor speed", "", "83.0"),
        ("record", "", "83.0"),
        ("gear twist", "along the motion", "30.0"),
    ]
    assert table.rows[1][4:] == ("check", "")
    assert table.note.endswith("less than 5 %: motor angle")


def test_an_event_on_an_axis_that_slides_is_a_force() -> None:
    sliding = replace(NAMED, unit="m/s", causes=(), events=(PUSH,))
    assert diagnose.sentence(sliding).endswith("a bump of force by 0.3 N in set1, from 1.7 to 2.5 s")


def test_clean_is_short(capsys: pytest.CaptureFixture[str]) -> None:
    tables = diagnose.tables(CLEAN)
    assert [table.title for table in tables] == ["Diagnosis of m3", "Records", "Detection limits"]
    assert "clean" in shown(tables, capsys)
    found = printed(diagnose.document(CLEAN), capsys)
    assert (found["verdict"], found["causes"], found["rejected"]) == ("clean", [], [])


def test_rounding_is_shown_as_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    records = {name: replace(one, rmse=7e-159, misfit=7e-159) for name, one in CLEAN.records.items()}
    still = replace(CLEAN, misfit=7e-159, remaining=7e-159, records=records)
    assert "e-159" not in shown(diagnose.tables(still), capsys)


@pytest.mark.parametrize(
    ("diagnosis", "sentence"),
    [
        (CLEAN, "m3 leaves nothing to explain beyond the noise of 0.01 rad/s"),
        (
            replace(CLEAN, torque_errors=0.162),
            "m3 leaves no more than errors of the torque of 0.16 Nm would, 0.01 rad/s",
        ),
        (
            NAMED,
            "m3 lacks motor.stribeck (or motor.presliding: these data cannot tell), which explains 97.0 %, "
            "and record_change.day2.arm.inertia.J, which explains 2.0 % of day2; 3.0 % of the misfit's energy remains, "
            "0.011 of 0.13 rad/s",
        ),
        (
            replace(NAMED, verdict="partly named", causes=NAMED.causes[:1], remaining=0.1, remaining_share=0.6),
            "m3 lacks among others motor.stribeck (or motor.presliding: these data cannot tell), which explains 97.0 %;"
            " 60.0 % of the misfit's energy remains, 0.1 of 0.13 rad/s",
        ),
        (
            replace(NAMED, causes=NAMED.causes[:1], remaining_share=0.0, torque_errors=0.162),
            "m3 lacks motor.stribeck (or motor.presliding: these data cannot tell), which explains 97.0 %; what"
            " remains, 0.011 of 0.13 rad/s, is no more than errors of the torque of 0.16 Nm would cause",
        ),
        (
            replace(NAMED, causes=NAMED.causes[:1], remaining=0.2, remaining_share=0.005),
            "m3 lacks motor.stribeck (or motor.presliding: these data cannot tell), which explains 97.0 %; weighed by"
            " the noise of every frequency 0.5 % of the misfit's energy remains, but the simulation errs by more than"
            " before, 0.2 rad/s after 0.13 rad/s",
        ),
        (
            replace(UNKNOWN, is_cut_short=True),
            "m3 is wrong by 0.13 rad/s that no effect that was examined in time explains; it follows the motor angle"
            " best",
        ),
        (
            UNKNOWN,
            "m3 is wrong by 0.13 rad/s that no effect of the catalogue explains; it follows the motor angle best",
        ),
        (
            replace(CLEAN, verdict="unknown"),
            "m3 leaves 0.01 rad/s that may be noise, and would hide whatever is missing",
        ),
    ],
    ids=[
        "clean",
        "clean beside torque errors",
        "named",
        "partly named",
        "named beside torque errors",
        "named, with a larger plain error",
        "cut short",
        "unknown",
        "hidden by noise",
    ],
)
def test_the_verdict_in_a_sentence(diagnosis: Diagnosis, sentence: str) -> None:
    assert diagnose.sentence(diagnosis) == sentence


def test_an_extension_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    found = printed(extend.document(EXTENSION), capsys)
    assert found["before"] == {"fit_percent": {"set1": 96.1, "check": 95.0}, "rmse": {"set1": 0.132, "check": 0.14}}
    assert found["after"]["fit_percent"] == {"set1": 99.8, "check": 99.2}
    assert found["gain"]["fit_percent"] == pytest.approx({"set1": 3.7, "check": 4.2})
    assert found["heldout"]["fit_percent"] == pytest.approx({"check": 4.2})
    assert found["heldout"]["rmse"] == pytest.approx({"check": 0.1288})
    assert (found["bic_before"], found["bic_after"]) == (1000, -4000)
    assert found["extended"] == "extended.yaml"
    assert found["model_before"] == ["motor.inertia", "motor.coulomb"]
    assert found["model_after"] == ["motor.inertia", "motor.coulomb", "motor.stribeck"]
    assert found["dropped"][0]["heldout_gain"] is None


def test_an_extension_in_tables(capsys: pytest.CaptureFixture[str]) -> None:
    tables = extend.tables(EXTENSION)
    text = shown(tables, capsys)
    assert [table.title for table in tables][1:3] == ["Records of the fit", "Held-out records"]
    assert [row[0] for table in tables[1:3] for row in table.rows] == ["set1", "check"]
    for fact in ("motor.stribeck", "4.20", "-92.0", "-4000", "its worth is gone", "extended.yaml"):
        assert fact in text


def test_what_an_extension_gained_in_a_sentence() -> None:
    assert extend.sentence(EXTENSION) == "with motor.stribeck, m3 simulates held-out check from 95.00 to 99.20 %"
    nothing = replace(EXTENSION, added=())
    assert extend.sentence(nothing) == "nothing was added to m3"


def test_an_extension_says_of_which_records_the_events_are_accounted_for(capsys: pytest.CaptureFixture[str]) -> None:
    eventful = replace(EXTENSION, events=(PUSH, replace(PUSH, start=3.0, end=3.1)))
    fitted, held_out = extend.tables(eventful)[1:3]
    assert (fitted.note, held_out.note) == ("set1: events accounted for", "")
    assert printed(extend.document(eventful), capsys)["events_accounted_for"] == ["set1"]
    assert printed(extend.document(EXTENSION), capsys)["events_accounted_for"] == []
    pushed = replace(eventful, events=(replace(PUSH, record="check"),))
    in_pieces = replace(EXTENSION, fit=replace(EXTENSION.fit, horizon=0.25))
    assert extend.sentence(in_pieces).endswith("from 95.00 to 99.20 %, in pieces of 0.25 s")
    assert extend.sentence(pushed).endswith("held-out check (event accounted for) from 95.00 to 99.20 %")
    assert "event" not in extend.sentence(eventful)
