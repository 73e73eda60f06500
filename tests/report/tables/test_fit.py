"""The fit as tables and JSON: what makes it doubtful stands in both."""

from __future__ import annotations

from dataclasses import replace

from support.diagnosed import FIT

from robotid.estimate.result import Fits
from robotid.report.tables.fit import document, sentence, tables

DOUBT = "the inertia of the fit is 17 times that of its start"


def fits(*remarks: str) -> Fits:
    return Fits({"m3": replace(FIT, remarks=remarks)}, "m3")


def test_remarks_stand_under_the_ends_of_the_fits() -> None:
    assert tables(fits(DOUBT))[-1].note == f"m3: {DOUBT}\nlater stages use m3"
    assert tables(fits())[-1].note == "later stages use m3"


def test_remarks_are_in_the_document() -> None:
    assert document(fits(DOUBT))["models"]["m3"]["remarks"] == (DOUBT,)


def test_a_doubt_and_its_cure_are_the_headline() -> None:
    assert sentence(fits()) == ""
    assert sentence(fits(DOUBT)) == f"m3: {DOUBT}"
    assert sentence(fits(DOUBT, "another", "add constant_torque")) == f"m3: {DOUBT}; add constant_torque"
