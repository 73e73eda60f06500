"""Every figure of a report: named, labelled, drawn, written."""

from __future__ import annotations

import re
import struct
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from support.diagnosed import CLEAN, UNKNOWN
from support.report_findings import findings, with_events

from robotid.errors import ConfigError
from robotid.report.drawing.correlation import draw_correlation
from robotid.report.drawing.layout import matrix_figure
from robotid.report.drawing.parameters import interval_colours
from robotid.report.evidence.gather import with_evidence
from robotid.report.findings import Findings
from robotid.report.save import FORMATS, Size, check_format, letters_remark, save_figure
from robotid.report.sections import FigureSpec, figure_specs
from robotid.report.style.axes import BLUE, VERMILLION, new_figure
from robotid.validation.results import Perturbation

NAMES = [
    "time-small", "time-large", "bode-speed", "bode-acceleration", "parameters", "correlation-of-m",
    "correlation-of-m-extended", "iterations", "spectrum-small", "correlations-small", "spectrum-large",
    "correlations-large", "misfit-dphi_m-by-direction", "misfit-reversal", "misfit-frequency", "misfit-twist",
    "misfit-tau_m", "misfit-ddphi_m", "misfit-phi_a-by-speed", "misfit-record", "misfit-phi_m-mod-2-pi", "misfit-t",
    "missing-small", "missing-large", "causes", "gain", "perturbation", "record-small", "record-large",
]  # fmt: skip


@cache
def by_name() -> dict[str, FigureSpec]:
    return {spec.name: spec for spec in figure_specs(with_evidence(findings()))}


@cache
def drawn(name: str) -> Figure:
    return by_name()[name].draw()


def labels(figure: Figure) -> list[str]:
    return [label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_all_figures_are_there_in_order() -> None:
    assert list(by_name()) == NAMES
    assert all(spec.alt.endswith(".") for spec in by_name().values())


@pytest.mark.parametrize("name", NAMES)
def test_quantities_have_units(name: str) -> None:
    written = labels(drawn(name))
    without = [label for label in written if not re.search(r"\[.+\]", label.replace("\n", " "))]
    assert set(without) <= {
        "record",
        "iteration",
        "cost over its end",
        "with itself",
        "with the torque",
        "coherence",
        "correlation",
    }
    assert written or name.startswith(("parameters", "perturbation", "correlation-of"))


def test_measured_responses_stand_alone_only_without_a_model_beside_them() -> None:
    names = [spec.name for spec in figure_specs(replace(findings(), validation=None))]
    assert "responses" in names
    assert "bode-speed" not in names


@pytest.mark.parametrize("form", FORMATS)
def test_written_whole_in_every_format(form: str, tmp_path: Path) -> None:
    start = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[form]
    for name in ("time-small", "perturbation"):
        file = tmp_path / f"{name}.{form}"
        save_figure(drawn(name), file)
        assert file.read_bytes().startswith(start)
    assert len(list(tmp_path.iterdir())) == 2


def test_a_format_that_cannot_be_drawn_is_refused() -> None:
    with pytest.raises(ConfigError, match='"doc"; use png, svg, pdf'):
        check_format("doc", "--format")


@pytest.mark.parametrize("form", FORMATS)
def test_a_smaller_figure_shrinks_as_a_whole(form: str, tmp_path: Path) -> None:
    figure, file = by_name()["parameters"].draw(), tmp_path / f"parameters.{form}"
    wide, high = (float(side) for side in figure.get_size_inches())
    assert save_figure(figure, file, Size(88, 60)) == pytest.approx(88 / 25.4 / wide)
    assert figure.get_size_inches() == pytest.approx([wide, wide * 60 / 88])
    assert figure.get_size_inches()[1] >= high
    written = file.read_bytes()
    if form == "png":
        assert struct.unpack(">II", written[16:24]) == (1039, 708)
    elif form == "pdf":
        assert re.search(rb"/MediaBox \[ 0 0 249\.4\d* 170\.0\d* \]", written)
    else:
        assert b'width="249.448' in written
        assert f'viewBox="0 0 {72 * wide:.6g}'.encode() in written


def test_letters_that_shrink_too_far_are_said() -> None:
    assert letters_remark(0.7, "gain", Size(88, 60)) == letters_remark(0.2, "gain", None) == ""
    said = "letters of gain are 4.0 points high; --size 110x75 makes them 5"
    assert letters_remark(0.5, "gain", Size(88, 60)) == said


def test_a_larger_figure_keeps_its_letters(tmp_path: Path) -> None:
    figure = by_name()["gain"].draw()
    assert save_figure(figure, tmp_path / "gain.pdf", Size(300, 200)) == 1.0


def test_a_figure_of_many_axes_has_room_in_any_size(tmp_path: Path) -> None:
    figure = new_figure(4, 3)
    for axes in figure.subplots(6, 6).ravel():
        axes.set_xlabel("a label that takes room")
        axes.set_ylabel("another")
    assert save_figure(figure, tmp_path / "small.png", Size(20, 20)) < 0.2


def test_before_and_after_are_compared() -> None:
    upper, lower = drawn("time-large").axes
    assert [line.get_label() for line in upper.get_lines()] == ["measured", "before the extension", "after it"]
    before, after, zero = (np.asarray(line.get_ydata()) for line in lower.get_lines())
    assert np.abs(before).max() == pytest.approx(0.04, rel=1e-2)
    assert np.abs(after).max() == pytest.approx(0.002, rel=1e-2)
    assert not zero.any()
    assert upper.get_title(loc="left") == "large (held out): fit 95.00 → 99.20 %"


def test_figures_say_whether_events_are_accounted_for() -> None:
    specs = {spec.name: spec for spec in figure_specs(with_evidence(with_events()))}
    both = "Both simulations account for the events: a torque of 0.3 Nm from 0.7 to 0.9 s and friction that is larger"
    both = f"{both} by 0.16 Nm from 1.2 s on in small."
    assert specs["time-small"].title == "small (fitted, events accounted for): fit 96.10 → 99.80 %"
    assert specs["time-large"].title == "large (held out): fit 95.00 → 99.20 %"
    assert all(specs[name].alt.endswith(both) for name in ("time-small", "gain", "spectrum-small"))
    left = "The events in small are not accounted for."
    assert all(specs[name].alt.endswith(left) for name in ("correlations-small", "perturbation"))
    assert not any("event" in spec.alt for name, spec in specs.items() if name.endswith("-large"))
    plain = {spec.name: spec for spec in figure_specs(replace(with_events(), extension=None))}
    assert plain["time-small"].alt.endswith(left)


def test_curves_show_mean_and_spread() -> None:
    curve = next(c for c in findings().diagnosis.curves if c.along == "twist")
    axes = drawn("misfit-twist").axes[0]
    before = next(line for line in axes.get_lines() if line.get_label() == "asked for, before")
    np.testing.assert_allclose(before.get_ydata(), curve.missing_torque)
    band = axes.collections[0].get_paths()[0].vertices[:, 1]
    assert band.max() == pytest.approx((curve.missing_torque + curve.spread).max())
    assert axes.get_title(loc="left") == "gear twist: accounts for 22 %"
    limits = {drawn(name).axes[0].get_ylim() for name in NAMES if name.startswith("misfit") and "freq" not in name}
    assert len(limits) == 1


def test_the_better_way_of_counting_is_shown() -> None:
    assert "misfit-dphi_m" not in NAMES
    assert "missing torque along the motion [Nm]" in labels(drawn("misfit-dphi_m-by-direction"))


def test_causes_are_ranked_with_their_twins() -> None:
    written = texts(drawn("causes"))
    assert written[:3] == [
        "motor.stribeck or motor.presliding",
        "97.0 %, held out +4.20",
        "record_change.large.arm.inertia.J",
    ]
    assert "a cause gains on held-out records [% points]" in by_name()["causes"].alt
    widths = [patch.get_width() for patch in drawn("causes").axes[0].patches]
    assert widths[:2] == [97.0, 2.0]
    assert widths[2:] == sorted(widths[2:], reverse=True)


def test_held_out_records_are_apart_in_the_gain() -> None:
    fitted, apart = drawn("gain").axes
    assert [fitted.get_title(loc="left"), apart.get_title(loc="left")] == ["records of the fit", "held-out records"]
    assert texts(drawn("gain")) == ["small: 96.10 → 99.80", "large: 95.00 → 99.20"]
    assert fitted.get_ylim() == apart.get_ylim()


def test_the_heat_map_says_every_change() -> None:
    small = findings().validation.models["m"].records["small"].perturbation
    written = texts(drawn("perturbation"))
    assert len(written) == 4 * len(small.names)
    shades = [patch.get_facecolor()[:3] for patch in drawn("perturbation").axes[0].patches]
    assert sum(shades[0]) < sum(shades[4 * small.names.index("gear.cubic_spring.k3")])


def test_a_parameter_whose_change_diverges_is_said() -> None:
    f = findings()
    nan = Perturbation(20.0, ("motor.inertia.J",), np.array([np.nan]), np.array([-0.001]))
    record = replace(f.validation.models["m"].records["small"], perturbation=nan)
    models = {"m": replace(f.validation.models["m"], records={"small": record})}
    one = Findings("irb", validation=replace(f.validation, models=models))
    figure = next(spec for spec in figure_specs(one) if spec.name == "perturbation").draw()
    assert texts(figure) == ["diverges", "0"]


def test_parameters_have_intervals_in_handy_units() -> None:
    axes = {a.get_title(loc="left"): a for a in drawn("parameters").axes}
    assert "gear.spring.k1 [10⁶ Nm/rad]" in axes
    stribeck = axes["motor.stribeck.dFs [Nm]"]
    assert [label.get_text() for label in stribeck.get_yticklabels()] == ["m extended"]
    (caps, *_) = stribeck.collections
    assert np.ptp(caps.get_segments()[0][:, 0]) == pytest.approx(4 * 0.02)


@pytest.mark.parametrize("extended", [None, "b"])
def test_before_and_after_have_their_colours_in_every_figure(extended: str | None) -> None:
    found = interval_colours(["a", "b", "b extended"], extended)
    assert len(set(found.values())) == 3
    assert ((found["b"], found["b extended"]) == (VERMILLION, BLUE)) == (extended is not None)
    missing = drawn("missing-small").axes[0].get_lines()
    assert [line.get_color() for line in missing if line.get_label().endswith("after")] == [BLUE]
    strip = drawn("parameters").axes[0]
    shades = [shade.get_color() for shade in strip.collections]
    assert len(shades) == len(strip.get_yticks()) > 1
    assert to_hex(shades[0][0]).upper() == BLUE  # the extended model is the lowest
    assert [to_hex(shade[0]).upper() for shade in shades].count(VERMILLION) == 1


def test_a_title_stays_within_its_figure() -> None:
    fit = next(iter(findings().fits.models.values()))  # type: ignore[union-attr]
    few = replace(fit, parameters=tuple(replace(p, fixed=k > 2) for k, p in enumerate(fit.parameters)))
    figure = matrix_figure(draw_correlation, 3, "a_model_of_a_long_name extended", few)
    figure.canvas.draw()
    for axes in figure.axes:
        assert axes.title.get_window_extent().x1 <= figure.bbox.x1
        assert axes._left_title.get_window_extent().x1 <= figure.bbox.x1  # type: ignore[attr-defined]


def test_what_follows_the_torque_in_a_clean_record_is_said_with_its_size() -> None:
    f = findings()
    assert f.validation is not None
    assert f.diagnosis is not None
    best = f.validation.models[f.validation.best]
    for record in best.records.values():
        object.__setattr__(record, "residual", replace(record.residual, independence_p=1e-4))
    quiet = {name: replace(one, misfit=0.0) for name, one in f.diagnosis.records.items()}
    for diagnosis, said in ((f.diagnosis, False), (replace(f.diagnosis, records=quiet), True)):
        alts = [s.alt for s in figure_specs(replace(f, diagnosis=diagnosis)) if s.name.startswith("correlations-")]
        assert ["within the noise floor of the diagnosis" in alt for alt in alts] == [said] * len(best.records)


def test_a_sliding_axis_has_its_own_units() -> None:
    found = {spec.name: spec for spec in figure_specs(replace(findings(), linear=True))}
    assert "motor force [N]" in labels(found["record-small"].draw())
    assert labels(found["misfit-phi_m-mod-2-pi"].draw())[0] == "motor position within a turn [m]"
    assert labels(found["misfit-phi_a-by-speed"].draw())[1].startswith("missing force\nin proportion to speed, at ")


def test_a_fit_in_pieces_is_said_beside_its_curves() -> None:
    spec = next(spec for spec in figure_specs(replace(findings(), horizon=2.5)) if spec.name == "time-small")
    assert spec.alt.endswith("Simulated in pieces of 2.5 s, each from a first state of its own.")
    assert "pieces" not in by_name()["time-small"].alt


def test_a_curve_on_zero_is_explained() -> None:
    f = findings()
    assert f.diagnosis is not None
    one = f.diagnosis.missing["small"]
    explained = replace(f.diagnosis, missing={"small": replace(one, simulated=one.measured)})
    spec = next(s for s in figure_specs(replace(f, diagnosis=explained)) if s.name == "missing-small")
    assert "the residual is no more than noise and asks for nothing" in spec.alt
    assert "no more than noise" not in by_name()["missing-small"].alt


def test_what_is_unknown_has_a_shape() -> None:
    found = {spec.name: spec for spec in figure_specs(Findings("irb", diagnosis=UNKNOWN))}
    assert found["unknown"].draw().axes[0].get_xlabel() == "motor angle [rad]"
    assert not [name for name in (p.name for p in figure_specs(Findings("irb", diagnosis=CLEAN))) if name != "causes"]
