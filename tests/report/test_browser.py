"""The page in a real browser: no complaint, everything drawn, zoom and pan, phone, dark, paper."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.chromium import Page, browse, find_chromium
from support.report_findings import findings

from robotid.report.evidence.gather import with_evidence
from robotid.report.origin import Origin, Source
from robotid.report.page import StageTables, page
from robotid.report.tables.table import Table

CHROMIUM = find_chromium()
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on this system")

MADE = Source("fit", "model.h5", "robotid fit a.yaml", "1.0", "2025-01-01", "ab" * 32, {}, 1, {"python": "3.11"})
ORIGIN = Origin("0123", "robot: {}\n", (MADE,), {})
PLOT = "document.querySelector('#figure-time-small')"
WIDE_TABLE = ("what", *(f"a rather long heading {k}" for k in range(12)))
WIDE = Table("Wide", WIDE_TABLE, (WIDE_TABLE,), "x" * 300)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("page") / "report.html"
    file.write_text(page(with_evidence(findings()), (StageTables("Fit", (WIDE,)),), ORIGIN), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    assert CHROMIUM is not None
    with browse(CHROMIUM, tmp_path_factory.mktemp("chromium")) as tab:
        yield tab


@pytest.fixture
def shown(tab: Page, file: Path) -> Page:
    """The page at the size of a desk, its first plot in view."""
    tab.said.clear()
    tab.size(1200, 900)
    tab.open(file)
    tab.evaluate(f"{PLOT}.scrollIntoView()")
    return tab


def view(tab: Page) -> list[float]:
    """First and last time [s] that the plot shows, once it is drawn."""
    settle(tab)
    found: list[float] = tab.evaluate(f"{PLOT}.plot.view")
    return found


def settle(tab: Page) -> None:
    tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")


def at(tab: Page, share: float) -> tuple[float, float]:
    """A point of the plot [px], at a share of its time."""
    box = tab.evaluate(
        f"(() => {{ const b = {PLOT}.plot.svg.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; }})()"
    )
    left, wide = tab.evaluate(f"[{PLOT}.plot.place({PLOT}.plot.view[0]), {PLOT}.plot.wide]")
    return box[0] + left + share * wide, box[1] + 0.4 * box[3]


def drag(tab: Page, start: float, end: float, **more: int) -> None:
    x, y = at(tab, start)
    to, _ = at(tab, end)
    tab.mouse("mousePressed", x, y, button="left", clickCount=1, **more)
    tab.mouse("mouseMoved", to, y, button="left", buttons=1, **more)
    tab.mouse("mouseReleased", to, y, button="left", clickCount=1, **more)


def test_everything_is_drawn_without_complaint(shown: Page) -> None:
    settle(shown)
    figures = shown.evaluate("document.querySelectorAll('figure').length")
    full = "s.getBoundingClientRect().height > 60 && s.querySelectorAll('path').length > 3"
    drawn = shown.evaluate(f"[...document.querySelectorAll('figure svg')].filter((s) => {full}).length")
    assert drawn == figures > 20
    zoomable = shown.evaluate("document.querySelectorAll('figure.over-time').length")
    assert shown.evaluate("document.querySelectorAll('figure[data-drawn]').length") == zoomable == 6
    curves = shown.evaluate(f"[...{PLOT}.querySelectorAll('path.curve')].map((p) => p.getAttribute('d').length)")
    assert len(curves) == 5
    assert min(curves) > 3000
    assert not shown.evaluate(
        "[...document.querySelectorAll('[d]')].some((p) => /NaN|undef/.test(p.getAttribute('d')))"
    )
    assert shown.said == []


def test_drag_wheel_and_double_click(shown: Page) -> None:
    whole = view(shown)
    assert whole == pytest.approx([0.0, 1.4995])
    drag(shown, 0.2, 0.4)
    zoomed = view(shown)
    assert zoomed == pytest.approx([0.2 * 1.4995, 0.4 * 1.4995], abs=0.01)
    shown.evaluate(f"{PLOT}.plot.svg.focus()")
    x, y = at(shown, 0.5)
    shown.mouse("mouseWheel", x, y, deltaX=0, deltaY=-200)
    closer = view(shown)
    assert sum(closer) == pytest.approx(sum(zoomed), abs=0.01)
    assert closer[1] - closer[0] < 0.8 * (zoomed[1] - zoomed[0])
    drag(shown, 0.5, 0.25, modifiers=8)  # Shift
    panned = view(shown)
    assert panned[0] - closer[0] == pytest.approx(0.25 * (closer[1] - closer[0]), rel=0.05)
    for count in (1, 2):
        shown.mouse("mousePressed", x, y, button="left", clickCount=count)
        shown.mouse("mouseReleased", x, y, button="left", clickCount=count)
    assert view(shown) == whole
    assert shown.said == []


def test_the_strips_share_their_time_and_fit_what_is_seen(shown: Page) -> None:
    ends = f"[...{PLOT}.querySelectorAll('path.curve')].map((p) => p.getAttribute('d').match(/^M([\\d.-]+)/)[1])"
    shown.evaluate(f"{PLOT}.plot.look(0.5, 0.6)")
    settle(shown)
    assert len(set(shown.evaluate(ends))) == 1
    ticks = shown.evaluate(f"[...{PLOT}.querySelectorAll('svg text')].map((t) => t.textContent)")
    assert "0.54" in ticks
    assert "time [s]" in ticks
    assert "residual [rad/s]" in ticks


def test_a_curve_that_is_not_ranged_is_marked_where_it_leaves_the_figure(shown: Page) -> None:
    plot = "document.querySelector('#figure-missing-large').plot"
    series = f"{plot}.strips[0].series.find((s) => !s.ranged)"
    ranges = f"(() => {{ {plot}.draw(); return [{plot}.strips[0].low, {plot}.strips[0].high]; }})()"
    marks = f"{plot}.svg.querySelectorAll('.beyond').length"
    assert shown.evaluate(f"{series}.name") == "law of the extension"
    before, none = shown.evaluate(ranges), shown.evaluate(marks)
    shown.evaluate(f"{series}.values[1000] = -6")
    assert shown.evaluate(ranges) == before
    assert shown.evaluate(marks) == none + 1
    assert shown.said == []


def test_the_wheel_scrolls_the_page_until_the_plot_has_the_focus(shown: Page) -> None:
    whole = view(shown)
    x, y = at(shown, 0.5)
    shown.mouse("mouseWheel", x, y, deltaX=0, deltaY=-200)
    assert view(shown) == whole


def test_keys_and_buttons(shown: Page) -> None:
    whole = view(shown)
    shown.evaluate(f"{PLOT}.plot.svg.focus()")
    shown.key("+")
    half = view(shown)
    assert half[1] - half[0] == pytest.approx((whole[1] - whole[0]) / 2)
    shown.key("ArrowRight")
    assert view(shown)[0] > half[0]
    shown.key("0")
    assert view(shown) == whole
    shown.evaluate(f"{PLOT}.querySelector('[data-act=in]').click()")
    assert view(shown) == half
    key = f"{PLOT}.querySelector('[data-key=\"after it\"]')"
    shown.evaluate(f"{key}.click()")
    settle(shown)
    assert shown.evaluate(f"{PLOT}.querySelectorAll('path.curve').length") == 3
    assert shown.evaluate(f"{key}.getAttribute('aria-pressed')") == "false"


def test_fingers_pinch_and_pan(shown: Page) -> None:
    whole = view(shown)
    (a, y), (b, _), (c, _), (d, _) = (at(shown, share) for share in (0.4, 0.6, 0.2, 0.8))
    points = [
        [{"x": a, "y": y, "id": 0}, {"x": b, "y": y, "id": 1}],
        [{"x": c, "y": y, "id": 0}, {"x": d, "y": y, "id": 1}],
    ]
    shown.ask("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    for kind, touches in (("touchStart", points[0]), ("touchMove", points[1]), ("touchEnd", [])):
        shown.ask("Input.dispatchTouchEvent", type=kind, touchPoints=touches)
    pinched = view(shown)
    assert pinched[1] - pinched[0] == pytest.approx((whole[1] - whole[0]) / 3, rel=0.05)
    for kind, x in (("touchStart", d), ("touchMove", (c + d) / 2), ("touchMove", c), ("touchEnd", None)):
        shown.ask("Input.dispatchTouchEvent", type=kind, touchPoints=[] if x is None else [{"x": x, "y": y}])
    moved = view(shown)
    shown.ask("Emulation.setTouchEmulationEnabled", enabled=False)
    assert moved[0] > pinched[0]
    assert moved[1] - moved[0] == pytest.approx(pinched[1] - pinched[0])


def test_what_the_pointer_is_at_is_told(shown: Page) -> None:
    x, y = at(shown, 0.5)
    shown.mouse("mouseMoved", x, y)
    told = shown.evaluate(f"{PLOT}.querySelector('output').textContent")
    assert told.startswith("0.7497")
    assert "motor speed [rad/s]: measured" in told
    assert "residual [rad/s]: before the extension" in told


def test_no_row_of_figures_has_a_hole(shown: Page) -> None:
    figures = "[...grid.querySelectorAll(':scope > figure')]"
    tops = f"{figures}.map((f) => [f.className, Math.round(f.getBoundingClientRect().top)])"
    rows = shown.evaluate(f"[...document.querySelectorAll('section > .figures')].map((grid) => {tops})")
    assert sum(map(len, rows)) > 15
    for found in rows:
        for kind, top in found:
            beside = [other for other, at in found if at == top]
            assert len(beside) == (1 if kind.split()[:1] in (["wide"], ["alone"]) else 2), found
    odd = "[...document.querySelectorAll('section > .figures > .alone')]"
    ends = [f"f.querySelector('{part}').getBoundingClientRect()" for part in ("figcaption", ".still")]
    pairs = shown.evaluate(f"{odd}.map((f) => [{ends[0]}.left, {ends[1]}.right])")
    assert pairs
    assert all(caption > picture for caption, picture in pairs)


@pytest.mark.parametrize("dark", [False, True])
def test_a_phone_needs_no_scrolling_sideways(dark: bool, tab: Page, file: Path) -> None:
    tab.size(400, 800, dark=dark)
    tab.open(file)
    settle(tab)
    assert tab.evaluate("[document.documentElement.scrollWidth, innerWidth]") == [400, 400]
    texts = "[...document.querySelectorAll('figure:not(.wide) svg text')]"
    assert tab.evaluate(f"Math.min(...{texts}.map((t) => t.getBoundingClientRect().height))") > 7
    background = tab.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (background == "rgb(255, 255, 255)") is not dark


@pytest.mark.parametrize(
    "heading", ["<h3>a</h3><p class=note id=one>b</p>", "<details class=all-rows id=one></details>"]
)
def test_on_paper_what_stands_above_figures_and_tables_stays_with_them(tab: Page, file: Path, heading: str) -> None:
    tab.size(1200, 800)
    tab.open(file)
    tab.evaluate(f"document.body.insertAdjacentHTML('beforeend', '{heading}')")
    after = "getComputedStyle(document.querySelector('#one')).breakAfter"
    on_screen = tab.evaluate(after)
    tab.ask("Emulation.setEmulatedMedia", media="print")
    on_paper = tab.evaluate(after)
    tab.ask("Emulation.setEmulatedMedia", media="")
    assert (on_screen, on_paper) == ("auto", "avoid")


def test_on_paper_letters_are_of_one_size_and_low_figures_take_a_third_of_a_page(tab: Page, file: Path) -> None:
    """What does not fit goes to the next page and leaves as much empty. A Letter page holds 740 x 980 px."""
    tab.size(740, 980)
    tab.open(file)
    tab.ask("Emulation.setEmulatedMedia", media="print")
    shown = "[...document.querySelectorAll('.figures:not(details *) > figure')]"
    found = tab.evaluate(
        f"""{shown}.map((figure) => {{
            const svg = figure.querySelector("svg:not(.still svg)") ?? figure.querySelector(".still svg");
            const [box, own] = [svg.getBoundingClientRect(), svg.viewBox.baseVal];
            const still = svg.closest(".still") !== null;
            const high = figure.getBoundingClientRect().height;
            return {{still, high, scale: box.width / own.width, own: own.height}};
        }}).filter((one) => one.high > 0)"""
    )
    tab.ask("Emulation.setEmulatedMedia", media="")
    scales = [one["scale"] for one in found if one["still"]]
    assert len(scales) > 10
    assert max(scales) < 0.86
    assert sorted(scales)[len(scales) // 4] == pytest.approx(max(scales), abs=0.01), "but where a column is too narrow"
    low = [one["high"] for one in found if not one["still"] or one["own"] < 250]
    assert len(low) > 10
    assert max(low) < 980 / 3


def test_it_prints_and_works_without_scripts(tab: Page, file: Path, tmp_path: Path) -> None:
    tab.size(1200, 900, dark=True)
    tab.open(file)
    tab.print(tmp_path / "report.pdf")
    assert (tmp_path / "report.pdf").read_bytes().startswith(b"%PDF")
    tab.ask("Emulation.setScriptExecutionDisabled", value=True)
    try:
        tab.open(file)
        still = tab.evaluate("document.querySelectorAll('figure.over-time .still svg').length")
    finally:
        tab.ask("Emulation.setScriptExecutionDisabled", value=False)
    assert still == 6


def test_a_script_that_a_file_smuggled_in_does_not_run(tab: Page, file: Path, tmp_path: Path) -> None:
    smuggled = """<main><script>document.title = "run"</script><img src="x" onerror="document.title = 'run'">"""
    forged = tmp_path / "forged.html"
    forged.write_text(file.read_text(encoding="utf-8").replace("<main>", smuggled), encoding="utf-8")
    tab.open(forged)
    settle(tab)
    assert tab.evaluate("document.title") != "run"
    assert tab.evaluate(f"{PLOT}.dataset.drawn") == "yes"
    tab.said.clear()


OTHER = "document.querySelector('#figure-record-small')"
CURVE = "document.querySelector('#figure-misfit-dphi_m-by-direction')"


def test_figures_of_one_record_show_the_same_time_and_cursor(shown: Page) -> None:
    whole = shown.evaluate(f"{OTHER}.plot.view")
    drag(shown, 0.25, 0.5)
    seen = view(shown)
    assert shown.evaluate(f"{OTHER}.plot.view") == pytest.approx(seen)
    assert seen != pytest.approx(whole)
    assert shown.evaluate("document.querySelector('#figure-record-large').plot.view") == pytest.approx(whole)
    x, y = at(shown, 0.5)
    shown.mouse("mouseMoved", x, y)
    read = shown.evaluate(f"[{PLOT}, {OTHER}].map((f) => f.querySelector('output').textContent.split(' s ')[0])")
    assert read[0] == read[1]
    assert float(read[0]) == pytest.approx(sum(seen) / 2, rel=1e-2)


def test_values_can_be_zoomed_and_all_of_it_comes_back(shown: Page) -> None:
    shown.evaluate(f"{PLOT}.plot.svg.focus()")
    span = f"(() => {{ const s = {PLOT}.plot.strips[0]; return s.high - s.low; }})()"
    before = shown.evaluate(span)
    shown.key("ArrowUp")
    settle(shown)
    assert shown.evaluate(span) == pytest.approx(before / 2)
    shown.key("0")
    settle(shown)
    assert shown.evaluate(span) == pytest.approx(before)


def test_a_bin_shows_where_in_time_it_lies(shown: Page) -> None:
    bins = shown.evaluate(f"JSON.parse({CURVE}.querySelector('script').textContent).bins")
    k = next(k for k, one in enumerate(bins) if "small" in one["times"])
    strip = f"{CURVE}.querySelector('[data-bin=\"{k}\"]')"
    assert shown.evaluate(f"{strip}.getAttribute('role')") == "button"
    shown.evaluate(f"{strip}.dispatchEvent(new MouseEvent('click', {{ bubbles: true }}))")
    assert shown.evaluate(f"{PLOT}.plot.marks") == bins[k]["times"]["small"]
    settle(shown)
    assert shown.evaluate(f"{PLOT}.querySelectorAll('.mark').length") >= len(bins[k]["times"]["small"])
    told = shown.evaluate(f"{CURVE}.querySelector('output').textContent")
    assert told.startswith(f"{bins[k]['where']}: small")
    shown.evaluate(f"{strip}.dispatchEvent(new MouseEvent('click', {{ bubbles: true }}))")
    assert shown.evaluate(f"{PLOT}.plot.marks") == []
    assert shown.said == []


def test_tables_sort_by_size_and_are_saved(shown: Page, tmp_path: Path) -> None:
    table = "[...document.querySelectorAll('#parameters table')].find((t) => t.tHead)"
    heads = shown.evaluate(f"[...{table}.tHead.rows[0].cells].map((c) => c.textContent)")
    column = heads.index("value")
    values = (
        f"[...{table}.tBodies[0].rows].map((r) => parseFloat(r.cells[{column}].textContent.replace(/\u2212/g, '-')))"
    )
    shown.evaluate(f"{table}.tHead.rows[0].cells[{column}].querySelector('button').click()")
    assert shown.evaluate(values) == sorted(shown.evaluate(values))
    assert shown.evaluate(f"{table}.tHead.rows[0].cells[{column}].getAttribute('aria-sort')") == "ascending"
    shown.evaluate(f"{table}.tHead.rows[0].cells[{column}].querySelector('button').click()")
    assert shown.evaluate(values) == sorted(shown.evaluate(values), reverse=True)
    shown.ask("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    shown.evaluate(f"{table}.querySelector('.csv').click()")
    for _ in range(100):
        if (found := list(tmp_path.glob("*.csv"))) and found[0].read_text():
            break
        time.sleep(0.1)
    head, *rows = found[0].read_text(encoding="utf-8").splitlines()
    assert shown.evaluate(f"{table}.textContent.includes('kg m\u00b2')")
    assert {row.split(",")[1] for row in rows} >= {"kg m2", "Nm/rad"}
    assert head.split(",")[:3] == ["parameter", "unit", "value"]
    assert len(rows) == len(shown.evaluate(values))
    assert shown.said == []


def test_a_phone_says_what_scrolls(tab: Page, file: Path) -> None:
    tab.size(400, 800)
    tab.open(file)
    hint = "document.querySelector('#figure-parameters .hint')"
    shown = f"getComputedStyle({hint}).display"
    assert tab.evaluate(shown) == "block"
    assert tab.evaluate(f"{hint}.textContent") == "Scroll sideways for more →"
    tab.size(1200, 900)
    tab.open(file)
    assert tab.evaluate(shown) == "none"
