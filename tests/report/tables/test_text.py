"""Tables as plain text and HTML: numbers flush right, empty columns gone, nothing that a page could take for markup."""

from __future__ import annotations

from robotid.report.tables.table import Table
from robotid.report.tables.text import as_html, as_text

ROWS = (("set1", "99.5*", ""), ("a < b", "9.25", ""))
TABLE = Table(
    "Fit [%]", ("record", "m1", "remark"), (("set1", "99.5*", ""), ("a < b", "9.25", "")), "*: fitted\nbest: m1"
)


def test_numbers_are_flush_right_and_empty_columns_are_left_out() -> None:
    assert as_text([TABLE]).splitlines() == [
        "Fit [%]",
        "record      m1",
        "──────   ─────",
        "set1     99.5*",
        "a < b     9.25",
        "*: fitted",
        "best: m1",
    ]


def test_tables_stand_apart_and_heads_may_be_missing() -> None:
    facts = Table("", ("", ""), (("verdict", "clean"), ("unit", "rad/s")))
    assert as_text([facts, facts]) == "verdict   clean\nunit      rad/s\n\nverdict   clean\nunit      rad/s"


def test_powers_of_units_are_raised() -> None:
    table = Table("", ("model", "unit"), (("m2", "kg m2"),))
    assert as_text([table]).splitlines()[-1] == "m2      kg m²"
    assert "<td" in as_html([table])
    assert "kg m²</td>" in as_html([table])


def test_html_escapes_what_cells_hold() -> None:
    page = as_html([TABLE])
    assert '<td style="text-align: left">a &lt; b</td><td style="text-align: right">9.25</td>' in page
    assert page.endswith("<p>*: fitted<br>best: m1</p>")
    assert "remark" not in page
