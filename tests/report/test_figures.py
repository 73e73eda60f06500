"""Figures show what they are given: curves, labels, units; and write themselves."""

from __future__ import annotations

import sys
from dataclasses import replace
from io import BytesIO
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from support.diagnosed import CLEAN
from support.judged_records import clean_records, clean_responses
from support.report_findings import diagnosis, excitation, extension, fits, flex, validation

from robotid.errors import ConfigError
from robotid.estimate.flexible import FlexResult
from robotid.model.units import sliding
from robotid.report.drawing.frequency import tick_degrees
from robotid.report.drawing.parameters import draw_iterations
from robotid.report.drawing.residual import correlation_keys, draw_correlations
from robotid.report.figures import draw
from robotid.report.style.axes import MAX_POINTS, envelope, new_figure, style_axes, write_out_ticks
from robotid.signals.quality import Recordings
from robotid.signals.reference import Excitation


def recordings() -> Recordings:
    return Recordings(clean_records(), ())


def texts(figure: Figure) -> str:
    """Everything written on a figure's axes."""
    said = []
    for axes in figure.get_axes():
        said += [axes.get_title(loc="left"), axes.get_xlabel(), axes.get_ylabel()]
    said += [text.get_text() for legend in figure.findobj(Legend) for text in legend.get_texts()]
    return "\n".join(said)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (recordings, ["small (estimate)", "large (validate)", "motor torque [Nm]", "time [s]"]),
        (excitation, ["small", "reference speed [rad/s]"]),
        (flex, ["small, measured", "Motor torque to motor acceleration", "magnitude\n[rad/s²/Nm]", "frequency [Hz]"]),
        (fits, ["value over that of m", "iteration", "n"]),
        (
            validation,
            ["large, measured", "m0, linearised", "m, linearised (0.0 dB off)", "small (fitted): fit 100.00 %",
             "large (held out)", "residual\n[rad/s]", "lag [ms]", "magnitude\n[rad/s/Nm]"],
        ),
        (diagnosis, ["motor speed: accounts for 92 %", "gear twist [rad]", "missing torque [Nm]", "What m lacks"]),
        (extension, ["records of the fit", "held-out records", "large (held out): fit 95.00 → 99.20 %", "after it"]),
    ],
)  # fmt: skip
def test_what_a_figure_says(content, expected) -> None:
    figure = draw(content())
    for words in expected:
        assert words in texts(figure)
    png = BytesIO()
    figure.savefig(png, format="png")
    assert png.getvalue().startswith(b"\x89PNG")


def test_a_reference_in_one_record_alone_is_named() -> None:
    first, second = clean_records()
    followed = replace(second, ref=second.dphi_m, ref_kind="speed")
    assert "reference" in texts(draw(Recordings((replace(first, ref=None), followed), ())))


def test_magnitudes_are_those_of_the_responses() -> None:
    lines = draw(flex()).get_axes()[0].get_lines()
    np.testing.assert_allclose(lines[1].get_ydata(), np.abs(clean_responses()[1].response))
    speed = draw(validation()).get_axes()[0].get_lines()
    np.testing.assert_allclose(speed[0].get_ydata(), np.abs(clean_responses()[0].speed_response))
    best = validation().models["m"].bode
    assert best is not None
    model = np.interp(best.frequency, np.asarray(speed[-1].get_xdata()), np.asarray(speed[-1].get_ydata()))
    np.testing.assert_allclose(model, best.speed, rtol=0.05)


def test_the_residual_strip_is_the_difference() -> None:
    upper, lower, *_ = draw(replace(validation(), best="m0", frfs=())).get_axes()
    measured, simulated = (line.get_ydata() for line in upper.get_lines())
    np.testing.assert_allclose(lower.get_lines()[0].get_ydata(), measured - simulated, atol=1e-12)


def test_lags_outside_the_band_are_of_another_colour() -> None:
    axes = next(
        a for a in draw(replace(validation(), best="m0")).get_axes() if "small: coloured" in a.get_title("left")
    )
    inside, outside = axes.collections[-2:]
    test = validation().models["m0"].records["small"].residual
    assert len(outside.get_segments()) == np.sum(np.abs(test.autocorrelation) > test.band) > 0
    assert f"{len(outside.get_segments())} of {len(test.autocorrelation)} bars beyond" in axes.get_title("left")
    assert len(inside.get_segments()) + len(outside.get_segments()) == len(test.autocorrelation)
    assert not np.array_equal(inside.get_colors(), outside.get_colors())


def test_a_sliding_axis_has_its_own_units() -> None:
    assert "motor force [N]" in texts(draw(recordings(), sliding))
    assert "magnitude\n[m/s²/N]" in texts(draw(flex(), sliding))


def test_a_validation_without_responses_or_records() -> None:
    bare = replace(validation(), frfs=(), models={"m": replace(validation().models["m"], bode=None)})
    assert "frequency" not in texts(draw(bare))
    empty = replace(bare, models={"m": replace(bare.models["m"], records={})})
    assert draw(empty).get_axes() == []


def test_what_cannot_be_drawn_is_said() -> None:
    with pytest.raises(ConfigError, match="there is no figure of this"):
        draw({})
    with pytest.raises(ConfigError, match="nothing is left to explain"):
        draw(CLEAN)
    with pytest.raises(ConfigError, match="all records are measured"):
        draw(Excitation(()))
    with pytest.raises(ConfigError, match="a rigid axis has no flexibility"):
        draw(FlexResult((), (), (), (), {}, ("a rigid axis has no flexibility",)))


@pytest.mark.parametrize(
    ("low", "high", "step"), [(-4000, 90, 1440), (-500, 100, 180), (-200, 100, 90), (-140, -20, 45), (-96, -79, 5)]
)
def test_a_phase_of_any_range_has_ticks(low: float, high: float, step: float) -> None:
    axes = new_figure(3, 2).subplots()
    axes.set_ylim(low, high)
    tick_degrees(axes)
    ticks = [tick for tick in axes.get_yticks() if low <= tick <= high]
    assert len(ticks) > 1
    assert np.diff(ticks) == pytest.approx(step)


def test_a_record_too_short_to_tell_is_not_called_free_of_the_torque() -> None:
    short = replace(validation().models["m0"].records["small"].residual, cross_band=1.2)
    axes = new_figure(3, 3).subplots(2)
    draw_correlations(axes[0], axes[1], "short", short, 0.01)
    assert axes[1].get_title(loc="left") == "too short a record to tell: the band is wider than 1"
    assert short.verdict.endswith("so few independent stretches cannot tell")


def test_correlations_of_a_residual_of_nothing_are_drawn() -> None:
    left = validation().models["m0"].records["small"].residual
    nothing = replace(left, autocorrelation=0 * left.autocorrelation, crosscorrelation=0 * left.crosscorrelation)
    axes = new_figure(3, 3).subplots(2)
    draw_correlations(axes[0], axes[1], "still", replace(nothing, band=0.0, cross_band=0.0), 0.01)
    assert axes[0].get_ylim() == axes[1].get_ylim() == (-1.0, 1.0)


def test_the_envelope_keeps_every_peak() -> None:
    t = np.arange(100_000.0)
    signal = np.zeros(len(t))
    signal[[777, 50_001]] = 3.0, -4.0
    _, drawn = envelope(t, signal)
    assert len(drawn) <= MAX_POINTS
    assert (drawn.max(), drawn.min()) == (3.0, -4.0)


def test_no_global_state_of_matplotlib_is_touched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "matplotlib.pyplot", raising=False)  # other packages import it
    draw(flex())
    assert "matplotlib.pyplot" not in sys.modules


def test_labels_of_strips_do_not_run_into_each_other() -> None:
    figure = draw(recordings())
    figure.canvas.draw()
    strips = figure.get_axes()[:3]
    boxes = [axes.yaxis.label.get_window_extent() for axes in strips]
    assert strips[0].get_ylabel() == "motor torque [Nm]"
    assert all(upper.y0 > lower.y1 for upper, lower in pairwise(boxes))


def test_a_figure_of_a_diagnosis_leaves_out_what_tells_nothing() -> None:
    titles = [axes.get_title(loc="left") for axes in draw(diagnosis()).get_axes()]
    assert "motor torque: accounts for 8 %" in titles
    assert "frequency" in titles
    assert not [title for title in titles if title.startswith(("time:", "arm angle", "motor angle within", "record"))]


def written_ticks(figure: Figure) -> list[str]:
    """What stands at the ticks of the only vertical axis, once it is drawn, and beside that axis."""
    figure.canvas.draw()
    (axes,) = figure.axes
    return [*(tick.get_text() for tick in axes.get_yticklabels()), axes.yaxis.get_offset_text().get_text()]


def test_nothing_is_to_be_added_to_ticks() -> None:
    figure = new_figure(4.0, 3.0)
    axes = figure.subplots()
    axes.plot([1000.001, 1000.002])
    style_axes(axes, "", "")
    *ticks, beside = written_ticks(figure)
    assert beside == ""
    assert {"1000.0010", "1000.0020"} <= set(ticks)


def test_nothing_is_a_multiple_of_a_value_that_all_but_vanishes() -> None:
    found = fits()
    best = found.models[found.best]
    first, *others = best.parameters
    small = replace(best, parameters=(replace(first, value=1e-310), *others))
    labels = draw(replace(found, models={**found.models, found.best: small})).get_axes()[0].get_xticklabels()
    assert [label.get_text() for label in labels] == [p.name.replace(".", "\n") for p in others if not p.fixed]


def test_a_cost_that_hardly_moves_is_drawn_as_one() -> None:
    made, figure = fits(), new_figure(4.0, 3.0)
    hardly = {name: replace(fit, cost=np.array([1.00002, 1.00001, 1.0])) for name, fit in made.models.items()}
    draw_iterations(figure.subplots(), replace(made, models=hardly))
    assert max(map(len, written_ticks(figure))) <= len("1.0025")
    low, high = figure.axes[0].get_ylim()
    assert high - low == pytest.approx(0.02, rel=0.01)


def test_ticks_of_less_than_a_decade_are_not_rounded() -> None:
    figure = new_figure(4.0, 3.0)
    axes = figure.subplots()
    axes.semilogy([26.0, 34.0])
    write_out_ticks(axes.yaxis)
    ticks = [text for text in written_ticks(figure) if text]
    assert len(ticks) == len(set(ticks)) > 2


def test_small_ticks_of_a_logarithmic_axis_are_powers_of_ten() -> None:
    figure = new_figure(4.0, 3.0)
    axes = figure.subplots()
    axes.semilogy([1e-7, 1e-2])
    write_out_ticks(axes.yaxis)
    assert {"10⁻⁶", "0.001"} <= set(written_ticks(figure))


def test_small_ticks_carry_their_power_of_ten_themselves() -> None:
    figure = new_figure(4.0, 3.0)
    axes = figure.subplots()
    axes.plot([-2e-5, 3e-5], [0.1, 0.4])
    style_axes(axes, "gear twist [rad]", "")
    figure.canvas.draw()
    assert {"−2·10⁻⁵", "0", "1·10⁻⁵"} <= {tick.get_text() for tick in axes.get_xticklabels()}
    assert axes.xaxis.get_offset_text().get_text() == ""


def test_the_torque_of_an_axis_that_slides_is_a_force() -> None:
    test = validation().models["m0"].records["small"].residual
    axes = new_figure(3, 3).subplots(2)
    draw_correlations(axes[0], axes[1], "small", test, 0.01, sliding)
    texts = [axes[1].get_title(loc="left"), axes[1].get_ylabel(), *correlation_keys(sliding)[1]]
    assert "torque" not in " ".join(texts)
    assert "with the force" in texts
