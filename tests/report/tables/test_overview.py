"""The axes of a robot side by side: in a table, and in a paragraph."""

from __future__ import annotations

from dataclasses import replace

from support.report_findings import findings

from robotid.body.results import BodyResult, TorqueErrors
from robotid.report.findings import Findings
from robotid.report.summary import robot_summary
from robotid.report.tables.overview import overview
from robotid.signals.quality import Recordings

ALL = findings()
AXES = {
    "a1": ALL,
    "a2": replace(ALL, validation=None, diagnosis=None, extension=None),
    "a3": Findings("arm_a3"),
}


def test_a_row_an_axis_as_far_as_its_stages_have_come() -> None:
    table = overview(AXES)
    rows = dict(zip(AXES, table.rows, strict=True))
    records = ALL.validation.models[ALL.validation.best].records.values()
    held_out = [f"{r.fit_percent:.2f}" for r in records if not r.used]
    gains = [
        ALL.extension.after[name].fit_percent - ALL.extension.before[name].fit_percent
        for name, score in ALL.extension.after.items()
        if not score.used
    ]
    assert rows["a1"][0] == "a1"
    assert rows["a1"][3] == " to ".join(dict.fromkeys((min(held_out, key=float), max(held_out, key=float))))
    assert rows["a1"][4] == ALL.diagnosis.verdict
    assert all(cause.effect in rows["a1"][5] for cause in ALL.diagnosis.causes)
    assert rows["a1"][6].startswith(f"+{min(gains):.2f}")
    assert rows["a2"][1] == ALL.fits.best
    assert rows["a2"][2] != "-"
    assert rows["a2"][3:] == ("-", "-", "-", "-")
    assert rows["a3"][1:] == ("-",) * 6


def test_a_robot_with_a_body_has_its_torque_error_on_held_out_records() -> None:
    errors = (
        TorqueErrors("day1", True, (1.0, 2.0), (3.0, 4.0)),
        TorqueErrors("day2", False, (90.0, 91.0), (14.44, 17.9)),
        TorqueErrors("day3", False, (90.0, 91.0), (12.0, 18.0)),
    )
    body = BodyResult(("a1", "a2"), (), 1.0, (), errors, {}, ())
    recordings = Recordings(ALL.recordings.records, ALL.recordings.reports, body)
    table = overview({axis: replace(ALL, recordings=recordings) for axis in ("a1", "a2", "a3")})
    assert table.columns[-1] == "body: torque error, held out [%]"
    assert [row[-1] for row in table.rows] == ["12.0 to 14.4", "17.9 to 18.0", "-"]
    assert len(overview(AXES).columns) == len(table.columns) - 1


def test_the_paragraph_names_the_axes_at_either_end_and_the_causes() -> None:
    text = robot_summary(AXES)
    assert text.startswith("3 axes. ")
    assert "On held-out records, the models fit from " in text
    assert f"{ALL.diagnosis.verdict.capitalize()}: a1 ({ALL.diagnosis.causes[0].effect}" in text
    assert robot_summary({"a3": AXES["a3"], "a4": AXES["a3"]}) == "2 axes."
