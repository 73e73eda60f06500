"""The page: whole, well formed, self-contained, and about what has run."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import fields, replace
from functools import cache
from itertools import groupby

import numpy as np
import pytest
from support.html_document import Document
from support.report_findings import findings

from robotid.model.units import typeset
from robotid.parallel import pool, working
from robotid.report.evidence.results import Evidence
from robotid.report.findings import Findings
from robotid.report.origin import Origin, Source
from robotid.report.page import (
    AXIS_FIGURES,
    MAX_ROWS,
    MAX_VALUES,
    SHOWN_ROWS,
    AxisPage,
    Head,
    StageTables,
    page,
    rendered,
    robot_page,
    written,
)
from robotid.report.sections import figure_specs
from robotid.report.stamp import Stamp, stamp_of
from robotid.report.summary import summary
from robotid.report.tables.table import Table

STAGES = [
    f.name for f in fields(Findings) if f.name not in ("robot", "linear", "horizon", "estimate_states", "evidence")
]
MADE = Source("fit", "model.h5", "robotid fit a.yaml", "1.0", "2025-01-01", "ab" * 32, {"collect": "cd" * 32}, 1, {})
ORIGIN = Origin("0123abcd", "robot:\n  name: irb\n", (MADE,), {})


TABLE = Table(
    "Parameters",
    ("parameter", "value", "remark", "none"),
    (("motor.inertia.J", "0.0121", "a <b> & so on", ""),),
    "sd: standard deviation",
)


def up_to(stage: str) -> Findings:
    """What there is once a stage has run."""
    later = STAGES[STAGES.index(stage) + 1 :]
    return replace(findings(), **dict.fromkeys(later))


@cache
def html(stage: str) -> str:
    return page(up_to(stage), (StageTables("Fit", (TABLE,)),), ORIGIN)


@pytest.mark.parametrize("stage", STAGES)
def test_a_page_after_every_stage(stage: str) -> None:
    found = up_to(stage)
    document = Document(html(stage))
    shown = figure_specs(found)
    assert shown or stage == "excitation"
    assert {f"figure-{spec.name}" for spec in shown} <= set(document.values("id"))
    assert document.tags["figure"] == len(shown)
    assert document.tags["svg"] == len(shown)
    assert typeset(summary(found)) in document.text.replace("\u00a0", " ")
    assert [document.tags[tag] for tag in ("h1", "title", "main")] == [1, 1, 1]


@pytest.mark.parametrize("stage", ["recordings", "extension"])
def test_it_needs_nothing_but_itself(stage: str) -> None:
    source = html(stage)
    document = Document(source)
    assert not re.search(r"https?:|//\w|url\((?!#)|@import", re.sub(r'content="[^"]*"|//.*', "", source))
    assert document.values("src") == []
    assert document.tags["link"] == 0
    identifiers = document.values("id")
    assert len(identifiers) == len(set(identifiers))
    referred = [value for value in document.values("href") if value.startswith("#")]
    assert {value[1:] for value in referred} <= set(identifiers)
    assert document.values("href") == referred


def test_tables_and_pictures_can_be_read_aloud() -> None:
    document = Document(html("extension"))
    labelled = [value for tag, name, value in document.attributes if name == "aria-label" and tag == "div"]
    assert len(labelled) >= document.tags["figure"]
    assert all(labelled)
    assert document.tags["th"] == document.values("scope").count("row") + document.values("scope").count("col") > 0
    assert document.values("lang") == ["en"]


@pytest.mark.parametrize("rows", [MAX_ROWS, MAX_ROWS + 1])
def test_a_long_table_is_folded_and_whole(rows: int) -> None:
    table = Table("Long", ("name", "value"), tuple((f"p{k}", str(k)) for k in range(rows)))
    text = rendered(Head("long", ""), (), (StageTables("Stage", (table,)),), ORIGIN)
    folded = f"<summary>The first {SHOWN_ROWS} of {rows} rows</summary>"
    assert (folded in text) is (rows > MAX_ROWS)
    assert f".scroll tbody tr:nth-child(n+{SHOWN_ROWS + 1})" in text
    assert all(f">p{k}</th>" in text for k in range(rows))


def test_a_table_is_shown_without_its_empty_columns() -> None:
    document = Document(html("excitation"))
    assert "Parameters parameter value remark motor.inertia.J 0.0121 a <b> & so on sd:" in document.text


def test_numbers_reach_the_page_as_they_are() -> None:
    record = findings().recordings.records[0]
    plot = next(
        json.loads(text) for text in re.findall(r'<script type="application/json">(.*?)</script>', html("recordings"))
    )
    torque, speed, angle = plot["strips"]
    assert angle["label"] == "motor angle [rad]"
    assert torque["label"] == "motor torque [Nm]"
    assert [series["name"] for series in speed["series"]] == ["reference", "measured"]
    np.testing.assert_array_equal(unpacked(torque["series"][0]["values"]), record.tau_m.astype("<f4"))
    time = plot["times"][torque["series"][0]["time"]]
    np.testing.assert_allclose(time["start"] + time["step"] * unpacked(time["samples"]), record.t, atol=1e-12)


def test_a_long_record_is_thinned_without_losing_its_peaks() -> None:
    recordings = findings().recordings
    tau_m = np.zeros(400_000)
    tau_m[[123_457, 300_001]] = 7.5, -9.25
    long = replace(recordings.records[0], tau_m=tau_m, phi_m=tau_m, dphi_m=tau_m, ref=None)
    source = page(Findings("irb", recordings=replace(recordings, records=(long,))), (), ORIGIN)
    plot = json.loads(re.findall(r'<script type="application/json">(.*?)</script>', source)[0])
    drawn, at = plot["strips"][0]["series"][0], plot["times"][0]
    values, samples = unpacked(drawn["values"]), unpacked(at["samples"])
    assert _numbers(source) <= MAX_VALUES
    assert (values.max(), values.min()) == (7.5, -9.25)
    t = at["start"] + at["step"] * samples
    assert t[np.argmax(values)] == pytest.approx(long.t[123_457])
    assert len(source) < 2_500_000
    assert f"{len(values)} of 400000 samples, the extremes of every stretch among them." in source
    assert "the extremes" not in html("extension")


def test_a_page_holds_so_many_numbers_however_many_long_records_there_are() -> None:
    recordings = findings().recordings
    waves = {name: np.sin(rate * np.arange(1e5)) for name, rate in (("tau_m", 0.01), ("phi_m", 0.02), ("dphi_m", 0.03))}
    first = replace(recordings.records[0], ref=None, **waves)
    records = [replace(first, name=f"long {k}") for k in range(12)]
    short = replace(first, name="short", **{name: wave[:900] for name, wave in waves.items()})
    source = page(Findings("irb", recordings=replace(recordings, records=(*records, short))), (), ORIGIN)
    assert 0.8 * MAX_VALUES < _numbers(source) <= MAX_VALUES
    assert len(source) < 5_000_000
    assert "of 900 samples" not in source


def _numbers(source: str) -> int:
    """That the signals of a page hold, times among them."""
    documents = [json.loads(text) for text in re.findall(r'<script type="application/json">(.*?)</script>', source)]
    series = [one["values"] for plot in documents for strip in plot["strips"] for one in strip["series"]]
    return sum(map(len, map(unpacked, [*series, *(t["samples"] for plot in documents for t in plot["times"])])))


def test_provenance_and_what_is_left_out() -> None:
    stale = replace(ORIGIN, left_out={"diagnosis.h5": "model.h5 is stale"})
    text = Document(page(up_to("fits"), (), stale)).text
    assert "robotid fit a.yaml" in text
    assert "abababababab" in text
    assert "Not shown here: diagnosis.h5 (model.h5 is stale)." in text
    assert "name: irb" in text
    assert "Not shown here" not in Document(html("extension")).text


def test_a_clean_verdict_is_said_where_the_misfit_would_be() -> None:
    f = findings()
    clean = Findings("irb", diagnosis=replace(f.diagnosis, verdict="clean", causes=()))
    said = "The verdict is clean: what these figures show lies within the noise, so they are folded."
    source = page(clean, (), ORIGIN)
    assert said in Document(source).text
    assert "law of the extension" not in source
    assert said not in Document(html("extension")).text


def test_negative_numbers_in_sentences_have_the_sign_of_a_minus_and_dates_their_hyphens() -> None:
    prose = written("up to -2 Nm and -3e-05 rad, on 2026-11-23, in set-2 (-1.5 %)")
    assert written("run `robotid fit --axis 1 -2` & wait") == "run <code>robotid fit --axis 1 -2</code> &amp; wait"
    assert prose == "up to −2 Nm and −3e-05 rad, on 2026-11-23, in set-2 (−1.5\u00a0%)"


def test_numbers_in_tables_have_signs_of_their_own() -> None:
    table = Table("", ("what", "value", "both"), (("set-1", "-3.2e-05", "-5.57 / +6.10"),), "")
    text = Document(page(up_to("fits"), (StageTables("Fit", (table,)),), ORIGIN)).text
    assert "set-1" in text
    assert "−3.2e−05" in text
    assert "−5.57 / +6.10" in text


def test_a_page_is_the_same_where_two_processes_draw_it(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("loky", reason="processes need loky")
    monkeypatch.setattr(pool, "START_UP", 0.0)
    with working(2):
        drawn = page(up_to("diagnosis"), (), ORIGIN)
    assert drawn == page(up_to("diagnosis"), (), ORIGIN)


def test_the_stamp_of_a_page() -> None:
    assert stamp_of(html("excitation")) == Stamp("0123abcd", summary(up_to("excitation")))
    assert stamp_of("<html></html>") is None


def test_a_title_of_ones_own_and_names_that_look_like_html() -> None:
    document = Document(page(replace(up_to("rigid"), robot="<script>x"), (), ORIGIN, title="A & <B>"))
    assert document.text.count("A & <B>") == 2
    assert "As a rigid joint <script>x has" in document.text


def test_the_head_carries_verdict_date_data_and_version() -> None:
    source = html("extension")
    head = re.search(r'<p class="head">(.*?)</p>', source, re.DOTALL)
    assert head is not None
    found = re.findall(r">([^<\n]+)<", head[1])
    assert found == ["named", "2025-01-01", "2 records, 3 s: 1 to fit, 1 held out", "robotid 1.0"]
    assert 'class="verdict named"' in head[1]


def test_figures_with_little_to_see_are_folded() -> None:
    source = html("extension")
    folded = "".join(re.findall(r'<details class="folded">(.*?)</details>', source, re.DOTALL))
    assert 'id="figure-misfit-phi_a-by-speed"' in folded
    assert 'id="figure-misfit-dphi_m-by-direction"' not in folded
    assert "4 more with little to see" in Document(source).text
    clean = page(Findings("irb", diagnosis=replace(findings().diagnosis, verdict="clean", causes=())), (), ORIGIN)
    before, _, after = clean.partition('<details class="folded">')
    assert "<figure" not in before
    assert re.search(r"\d+ figures with little to see", Document(clean).text)
    assert "figure-misfit-reversal" in after


def test_an_odd_figure_has_its_row_and_its_caption_beside_it() -> None:
    sections = re.findall(
        r'<div class="figures">(.*?)</div>\n(?:<details|<div|</section|</details)', html("extension"), re.DOTALL
    )
    kinds = [
        re.findall(r'<figure id="[^"]*" data-title="[^"]*" data-record="[^"]*" class="(\w*)', one) for one in sections
    ]
    assert sum("alone" in found for found in kinds) > 1
    for found in kinds:
        for wide, run in groupby(found, lambda kind: kind == "wide"):
            narrow = [kind or "pair" for kind in run if kind != "wide"]
            assert wide or [k for k in range(len(narrow)) if narrow[k] == "alone"] == [len(narrow) - 1] * (
                len(narrow) % 2
            )


def test_a_stage_without_a_table_has_no_heading() -> None:
    empty = StageTables("Second step", (replace(TABLE, rows=()),))
    text = Document(page(up_to("fits"), (empty, StageTables("Fit", (TABLE,))), ORIGIN)).text
    assert "Second step" not in text
    assert "Fit Parameters" in text


def test_a_clean_record_is_drawn_at_half_height() -> None:
    f = findings()
    quiet = replace(f.diagnosis.records["small"], misfit=0.001)
    clean = replace(f, diagnosis=replace(f.diagnosis, records=f.diagnosis.records | {"small": quiet}))
    low, high = (
        next(spec.plot for spec in figure_specs(found) if spec.name == "time-small").heights for found in (clean, f)
    )
    assert low == pytest.approx([0.55 * height for height in high])


def test_a_table_of_parameters_has_precision_start_and_bounds() -> None:
    text = Document(html("extension")).text
    assert "Parameters of m parameter unit value sd sd [%] start lower bound upper bound" in text
    assert "Parameters of m extended" in text


def test_a_page_of_several_axes() -> None:
    part = AxisPage(replace(up_to("fits"), evidence=Evidence()), (StageTables("Fit", (TABLE,)),))
    source = robot_page({"a1": part, "a2": part}, ORIGIN, "robot")
    document = Document(source)
    identifiers = document.values("id")
    assert len(identifiers) == len(set(identifiers))
    assert {"figure-a1-record-small", "figure-a2-record-small", "a1-parameters", "a2-tables"} <= set(identifiers)
    assert document.values("data-record").count("small") == 2
    assert "2025-01-01 2 records, 3 s: 1 to fit, 1 held out robotid 1.0" in document.text
    assert document.text.count("Parameters of m parameter") == 2


def test_the_answer_of_one_axis_alone_stands_once_in_the_head() -> None:
    found = replace(up_to("validation"), evidence=Evidence())
    source = robot_page({"a1": AxisPage(found, ())}, ORIGIN, "robot")
    assert source.count('<p class="answer">') == 1
    assert summary(found) in Document(source).text.replace("\u00a0", " ")


def test_the_head_of_several_axes_carries_the_verdict_of_each_that_has_one() -> None:
    found = replace(findings().diagnosis, missing={}, residuals={}, curves=())
    verdicts = {"a1": found, "a2": replace(found, verdict="partly named"), "a3": None}
    axes = {name: AxisPage(Findings("irb", diagnosis=one), ()) for name, one in verdicts.items()}
    head = re.search(r'<p class="head">(.*?)</p>', robot_page(axes, ORIGIN, "robot"), re.DOTALL)
    assert head is not None
    marks = re.findall(r'<strong class="verdict ([\w-]+)"><a href="#(.*?)">(\w+)</a>: (.*?)</strong>', head[1])
    assert marks == [("named", "axis-a1", "a1", "named"), ("partly-named", "axis-a2", "a2", "partly named")]


def test_tables_of_the_whole_robot_stand_once_behind_the_overview() -> None:
    part = AxisPage(up_to("fits"), ())
    common = replace(TABLE, title="Body: torque error [%]")
    source = robot_page({"a1": part, "a2": part}, ORIGIN, "robot", [common])
    assert source.count("<caption>Body: torque error [%]</caption>") == 1
    assert source.index("<caption>Overview") < source.index("<caption>Body") < source.index('id="axis-a1"')


def test_a_page_of_several_axes_shows_the_first_figures_of_a_section() -> None:
    part = AxisPage(findings(), ())
    alone, both = (Document(robot_page(axes, ORIGIN, "robot")) for axes in ({"a1": part}, {"a1": part, "a2": part}))
    drawn = [[i for i in page.values("id") if i.startswith("figure-a1-misfit")] for page in (alone, both)]
    folded = [f"figure-a1-{spec.name}" for spec in figure_specs(findings()) if spec.folded]
    assert len(set(drawn[0]) - set(folded)) > AXIS_FIGURES
    assert drawn[1] == [name for name in drawn[0] if name not in folded][:AXIS_FIGURES]
    assert {"figure-a1-missing-small", "figure-a1-missing-other"} & set(both.values("id"))
    left = re.findall(r"(\d+) more figures are on the page that robotid report --axis a2 writes\.", both.text)
    assert len(drawn[0]) - AXIS_FIGURES <= max(map(int, left))
    assert "on the page that `robotid report" not in alone.text


def unpacked(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), "<f4").astype(float)
