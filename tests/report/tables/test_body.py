"""The tables of a body: what the motions show stands first."""

from __future__ import annotations

from math import nan

from robotid.body.results import BaseParameter, BodyParameter, BodyResult
from robotid.report.tables.body import tables


def test_what_is_known_best_stands_first() -> None:
    base = (
        BaseParameter("unseen", nan, "kg", nan, False),
        BaseParameter("rough", 1.0, "kg", 0.5, True),
        BaseParameter("precise", -2.0, "kg", 0.1, True),
    )
    links = (
        BodyParameter("given", 3.0, "kg", 0.0, 3.0, 0.0, True),
        BodyParameter("kept", 1.0, "kg", 0.5, 1.0, 0.0, False),
        BodyParameter("seen", 1.0, "kg", 0.1, 2.0, 0.9, False),
        BodyParameter("precise_without_start", 1.0, "kg", 0.1, nan, 0.0, False),
        BodyParameter("rough_without_start", 1.0, "kg", 0.8, nan, 0.0, False),
    )
    _, parameters, combined = tables(BodyResult(("a1",), base, 10.0, links, (), {}, ()))
    assert [row[0] for row in parameters.rows] == [
        "precise_without_start",
        "seen",
        "rough_without_start",
        "kept",
        "given",
    ]
    assert [row[0] for row in combined.rows] == ["precise", "rough", "unseen"]
