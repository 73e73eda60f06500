"""Tables of several axes: those of each, and those of the robot once."""

from __future__ import annotations

from dataclasses import replace

from support.report_findings import findings

from robotid.body.results import BodyResult, TorqueErrors
from robotid.report.tables import by_axis, collect
from robotid.signals.quality import Recordings

BODY = BodyResult(("a1", "a2"), (), 1.0, (), (TorqueErrors("day1", True, (1.0, 2.0), (3.0, 4.0)),), {}, ())
ALONE = Recordings(findings().recordings.records, findings().recordings.reports, BODY)


def titles(axes: dict[str, Recordings]) -> list[str]:
    return [table.title for table in by_axis.tables(collect, axes, dict.fromkeys(axes, False))]


def test_the_body_of_several_axes_is_shown_once_and_after_them() -> None:
    one, two = titles({"a1": ALONE}), titles({"a1": ALONE, "a2": ALONE})
    of_body = [title for title in two if "Body" in title]
    assert of_body == two[-len(of_body) :]
    assert of_body[0] == "Body: torque error [%]"
    assert len(two) == 2 * (len(one) - len(of_body)) + len(of_body)
    assert [title for title in one if "Body" in title] == [f"a1: {title}" for title in of_body]


def test_a_single_joint_has_its_body_without_a_name() -> None:
    assert titles({"": ALONE})[-1] == "Body: base parameters"
    assert not [title for title in titles({"": replace(ALONE, body=None)}) if "Body" in title]
