"""What figures show beside the results of the stages: the law itself, spectra, responses; and that they draw it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure
from support.accompanied import record
from support.diagnosed import STRIBECK
from support.judged_records import CONTROLLER, clean_records, clean_responses, model
from support.report_findings import findings, with_events

from robotid.catalogue import assemble
from robotid.diagnosis.refit.settings import REFIT
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import simulate_record
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.least_squares import Solution, SolveOptions, solve
from robotid.estimate.residual import OutputError
from robotid.estimate.responses import nonlinear_torque
from robotid.estimate.result import FitResult
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.numerals import listed
from robotid.report.evidence import gather
from robotid.report.evidence.beyond import Binned, beyond
from robotid.report.evidence.companions import companion_curves
from robotid.report.evidence.gather import with_evidence
from robotid.report.evidence.profile import NO_END, Profiles, doubtful, profile_intervals
from robotid.report.evidence.response import coherence, simulated_response
from robotid.report.evidence.samples import in_bins, samples, stretches
from robotid.report.evidence.spectrum import residual_spectra
from robotid.report.findings import Findings
from robotid.report.sections import figure_specs
from robotid.report.style.svg import inline
from robotid.report.tables.fit import parameter_table
from robotid.signals.frf import estimate_frf
from robotid.signals.quality import Recordings
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.signals.trace import Trace
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

SIGMA = 0.02  # [rad/s]


@cache
def found() -> Findings:
    return with_evidence(findings())


@cache
def drawn(name: str) -> Figure:
    return next(spec for spec in figure_specs(found()) if spec.name == name).draw()


def curves(figure: Figure) -> dict[str, np.ndarray]:
    """Of all axes by their names in the legend."""
    return {str(line.get_label()): np.asarray(line.get_ydata()) for axes in figure.axes for line in axes.get_lines()}


def noisy(record: Record) -> Record:
    rng = np.random.default_rng(1)
    return replace(record, dphi_m=record.dphi_m + SIGMA * rng.standard_normal(len(record)))


@pytest.mark.parametrize("name", ["small", "large"])
def test_the_law_is_that_of_the_added_effect(name: str) -> None:
    law = found().evidence.laws[name]
    dFs, vs = (p.value for p in STRIBECK.parameters)
    speed = law.variables["dphi_m"]
    expected = -dFs * np.exp(-((speed / vs) ** 2)) * np.sign(speed)
    known = np.isfinite(law.torque)
    assert known.mean() > 0.9
    assert np.sqrt(np.mean((law.torque - expected)[known] ** 2)) < 0.02 * dFs


def test_a_law_is_kept_at_the_samples_that_are_drawn() -> None:
    f = found()
    assert f.diagnosis is not None
    whole, few = f.diagnosis.missing["large"], f.diagnosis.missing["large"].t[3::100]
    thinned = Trace(few, whole.measured[3::100], whole.simulated[3::100], whole.unit)
    diagnosis = replace(f.diagnosis, missing={**f.diagnosis.missing, "large": thinned})
    law = with_evidence(replace(findings(), diagnosis=diagnosis)).evidence.laws["large"]
    np.testing.assert_array_equal(law.t, few)
    np.testing.assert_array_equal(law.torque, f.evidence.laws["large"].torque[3::100])
    for name, values in law.variables.items():
        np.testing.assert_array_equal(values, f.evidence.laws["large"].variables[name][3::100])


def test_the_law_is_drawn_and_not_what_is_asked_less_what_is_left() -> None:
    shown, law = curves(drawn("missing-large")), found().evidence.laws["large"].torque
    np.testing.assert_array_equal(shown["law of the extension"][: len(law)], law)
    missing = found().diagnosis.missing["large"]
    np.testing.assert_allclose(shown["asked for by the residual"], missing.measured)
    np.testing.assert_allclose(shown["still asked for, after"], missing.measured - missing.simulated)
    assert np.nanmax(np.abs(law - missing.simulated)) > 0.05
    assert ">law of the extension<" in inline(drawn("missing-large"), "missing-large")


def with_law_of(torque: float) -> Findings:
    """The findings, but that the law of the extension jumps once, to a torque [Nm] that no residual asks for."""
    f = found()
    law = f.evidence.laws["large"]
    jumps = law.torque.copy()
    jumps[1000] = torque
    laws = {**f.evidence.laws, "large": replace(law, torque=jumps)}
    return replace(f, evidence=replace(f.evidence, laws=laws))


def test_the_range_of_missing_torque_is_that_of_the_residual_and_what_lies_beyond_is_marked() -> None:
    plain = next(spec for spec in figure_specs(found()) if spec.name == "missing-large")
    spec = next(spec for spec in figure_specs(with_law_of(-6.0)) if spec.name == "missing-large")
    before, after = plain.draw().axes[0], spec.draw().axes[0]
    assert after.get_ylim() == before.get_ylim()
    assert after.get_ylim()[0] > -1.0
    (mark,) = [line for line in after.get_lines() if line.get_marker() == "v"]
    assert list(mark.get_xdata()) == [found().evidence.laws["large"].t[1000]]
    assert "Triangles stand where the law goes beyond the range of what is asked for, up to -6 Nm." in spec.alt
    assert "beyond" not in plain.alt


def test_samples_lie_along_the_twist_that_the_diagnosis_ordered_by() -> None:
    f = found()
    assert f.diagnosis is not None
    curve = next(c for c in f.diagnosis.curves if c.along == "twist")
    twist = {name: np.linspace(-1e-3, 1e-3, len(trace.t)) for name, trace in f.diagnosis.missing.items()}
    for one in samples(replace(f, diagnosis=replace(f.diagnosis, twist=twist)), curve):
        np.testing.assert_array_equal(one.x, twist[one.record])


def test_without_an_extension_no_law_is_claimed() -> None:
    bare = with_evidence(replace(findings(), extension=None))
    figure = next(spec for spec in figure_specs(bare) if spec.name == "missing-large").draw()
    assert "law of the extension" not in curves(figure)
    assert not bare.evidence.laws


def test_a_curve_shows_samples_and_bins_before_and_after_and_the_law() -> None:
    name = "misfit-dphi_m-by-direction"
    shown = curves(drawn(name))
    curve = next(c for c in found().diagnosis.curves if c.along == "dphi_m, by direction")
    behind = samples(found(), curve)
    np.testing.assert_allclose(shown["asked for, before"], curve.missing_torque)
    law, left = in_bins(curve, behind, "law"), in_bins(curve, behind, "left")
    assert law is not None
    assert left is not None
    np.testing.assert_allclose(shown["law of the extension"], law.mean)
    np.testing.assert_allclose(shown["still asked for, after"], left.mean)
    assert np.nanmedian(left.mean) == pytest.approx(-0.01)
    assert 100 < len(shown["samples"]) <= 800
    assert np.nanmin(law.mean) < -0.1 < np.nanmax(law.mean)
    assert inline(drawn(name), name).count("data-bin=") == len(curve.x)


def test_bins_lie_where_the_record_is_in_them() -> None:
    curve = next(c for c in found().diagnosis.curves if c.along == "dphi_m")
    behind = samples(found(), curve)
    middle = int(np.argmin(np.abs(curve.x - 5.0)))
    for times in stretches(curve, behind)[middle].values():
        assert times == sorted(times)
    record, times = next(iter(stretches(curve, behind)[middle].items()))
    law = found().evidence.laws[record]
    first, last = times[0]
    speed = law.variables["dphi_m"][(law.t >= first - 1e-9) & (law.t <= last + 1e-9)]
    half = (curve.x[1] - curve.x[0]) / 2
    assert np.all(np.abs(speed - curve.x[middle]) <= half + 0.2)


def test_spectra_before_and_after_beside_the_noise_floor() -> None:
    record = noisy(clean_records()[0])
    wrong, right = (simulate_record(model(values), record) for values in ({"gear.spring.k1": 1.0e6}, {}))
    spectra = residual_spectra(wrong, right, "speed")
    level = SIGMA * np.sqrt(2 * record.sampling_time)
    high = spectra.frequency > 100.0
    np.testing.assert_allclose(spectra.noise[high], level, rtol=0.1)
    assert spectra.after is not None
    np.testing.assert_allclose(np.mean(spectra.after[high] ** 2), level**2, rtol=0.15)
    resonance = (spectra.frequency > 5) & (spectra.frequency < 20)
    assert spectra.before[resonance].max() > 10 * spectra.after[resonance].max()


def test_evidence_accounts_for_the_events_as_the_extension_does() -> None:
    eventful, calm = with_evidence(with_events()).evidence, found().evidence
    for name in ("small", "large"):
        with_them, without = eventful.spectra[name], calm.spectra[name]
        np.testing.assert_allclose(with_them.before, without.before, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(with_them.after, without.after, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(eventful.laws[name].torque, calm.laws[name].torque, rtol=1e-6, atol=1e-9)


def test_a_profile_is_on_the_records_as_its_fit_had_them(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = list[Record]()

    def noted(_: FitResult, records: Sequence[Record], horizon: float | None) -> Profiles:
        taken.extend(records)
        return Profiles({}, {})

    monkeypatch.setattr(gather, "profile_intervals", noted)
    f = with_events()
    with_evidence(f)
    of_fit, of_extension = taken
    recorded = f.recordings.records[0]
    np.testing.assert_array_equal(of_fit.tau_m, recorded.tau_m)
    np.testing.assert_allclose(of_extension.tau_m, clean_records()[0].tau_m, atol=1e-12)
    assert np.abs(of_fit.tau_m - of_extension.tau_m).max() == pytest.approx(0.3)


def test_the_spectrum_figure_draws_them() -> None:
    shown, spectra = curves(drawn("spectrum-small")), found().evidence.spectra["small"]
    np.testing.assert_array_equal(shown["before the extension"], spectra.before)
    np.testing.assert_array_equal(shown["after it"], spectra.after)
    np.testing.assert_array_equal(shown["noise floor"], spectra.noise)


def test_responses_have_magnitude_phase_coherence_and_the_extended_model() -> None:
    magnitude, phase, squared = drawn("bode-speed").axes[:3]
    labels = [axes.get_ylabel() for axes in (magnitude, phase, squared)]
    assert labels == ["magnitude\n[rad/s/Nm]", "phase [°]", "coherence"]
    named = magnitude.get_legend_handles_labels()[1]
    assert [name.partition(" (")[0] for name in named if "measured" not in name] == [
        "m0, linearised", "m, linearised", "m extended, simulated",
    ]  # fmt: skip
    frf = clean_responses()[0]
    bars = magnitude.containers[0].lines[2][0].get_segments()
    spans = np.array([[low, high] for (_, low), (_, high) in bars])
    np.testing.assert_allclose(spans[:, 1] - spans[:, 0], 4 * 0.01 / np.sqrt(2) * np.abs(frf.speed_response))
    drawn_phase = np.asarray(phase.get_lines()[0].get_ydata())
    expected = np.degrees(np.unwrap(np.angle(frf.speed_response)))
    np.testing.assert_allclose(np.mod(drawn_phase - expected + 180, 360), 180, atol=1e-6)
    assert "[dB]" in inline(drawn("bode-speed"), "bode-speed")


def test_a_simulated_response_is_estimated_as_the_measured_one() -> None:
    truth, records = model({}), clean_records()
    runs = {record.name: simulate_record(truth, record) for record in records}
    frfs = tuple(
        estimate_frf(r, (2.0, 40.0), torque=r.tau_m - nonlinear_torque(truth.joint, truth.parameters, r))
        for r in records
    )
    response = simulated_response(truth, runs, frfs)
    assert response is not None
    assert response.distance < 0.3
    softer = model({"gear.spring.k1": 1.0e6})
    other = simulated_response(softer, {r.name: simulate_record(softer, r) for r in records}, frfs)
    assert other is not None
    assert other.distance > 1.0
    assert simulated_response(truth, {}, frfs) is None


def test_coherence_is_the_share_that_is_not_noise() -> None:
    rng = np.random.default_rng(2)
    n = 200_000
    torque, noise = rng.standard_normal((2, n))
    record = Record.from_arrays(torque, np.cumsum(torque) * 1e-3, 1e-3, speed=torque + noise)
    shown = coherence(record, np.linspace(20, 400, 50))
    assert np.mean(shown.squared) == pytest.approx(0.5 + 0.5 / shown.averages * 0.5, abs=0.08)
    repeated = replace(record, period=10.0, dphi_m=torque)
    assert coherence(repeated, np.linspace(20, 400, 50)).squared == pytest.approx(np.ones(50))


@cache
def slippery() -> tuple[Record, FitResult]:
    """A short loud record of an axis with a faint Stribeck effect, and its fit."""
    effects = ("motor.inertia", "motor.viscous", "motor.coulomb", "motor.stribeck")
    truth = (0.01, 0.02, 0.5, 0.1, 1.0)
    joint = assemble(Structure(effects), angle=True)
    t = np.arange(1500) * 2e-3
    reference = Reference("short", 2e-3, 6 * np.sin(2 * np.pi * t), "speed")
    record = VirtualRobot(joint, np.array(truth), CONTROLLER).record(reference, 0)
    record = replace(record, dphi_m=record.dphi_m + 0.3 * np.random.default_rng(3).standard_normal(len(t)))
    joint = assemble(Structure(effects))
    parameters = joint.parameters().with_values(dict(zip(joint.names, truth, strict=True)))
    return record, fit_model("m", joint, parameters, (record,), FitOptions())


def test_a_profile_ends_where_the_fit_is_worse_than_chance_allows() -> None:
    record, fit = slippery()
    names = [p.name for p in doubtful(fit)]
    assert "motor.stribeck.vs" in names
    profiles = profile_intervals(fit, (record,), None)
    found = profiles.intervals
    assert list(found) == names
    assert not profiles.without
    p, interval = fit["motor.stribeck.vs"], found["motor.stribeck.vs"]
    assert interval.lower < p.value < interval.upper
    joint = assemble(fit.structure)
    for end in (interval.lower, interval.upper):
        if end in (p.lower, p.upper):
            continue
        values = {one.name: one.value for one in fit.parameters} | {p.name: end}
        parameters = joint.parameters().with_values(values)
        free = np.array([name != p.name for name in joint.names])
        other = fit_model("m", joint, replace(parameters, free=free), (record,), FitOptions())
        left = [100.0 - fit.fit_percent["short"], 100.0 - other.fit_percent["short"]]
        excess = np.sqrt(((left[1] / left[0]) ** 2 - 1) * len(record)) * p.std / p.std_robust
        assert excess == pytest.approx(2.0, rel=0.2)


def test_refits_start_where_the_linear_model_leads(monkeypatch: pytest.MonkeyPatch) -> None:
    record, fit = slippery()
    first: list[tuple[int, float]] = []

    def counted(problem: OutputError, start: Array, options: SolveOptions) -> Solution:
        found = solve(problem, start, options)
        if problem.max_failed_windows is not None:
            first.append((len(found.cost) - 1, found.cost[0] / found.cost[-1]))
        return found

    monkeypatch.setattr("robotid.report.evidence.profile.solve", counted)
    profile_intervals(fit, (record,), None)
    assert np.median([excess for _, excess in first]) < 1.03  # up to a fifth from the fit itself


def test_a_refit_that_sticks_begins_again_from_the_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    record, fit = slippery()
    starts: list[Array] = []

    def sticking(problem: OutputError, start: Array, options: SolveOptions) -> Solution:
        starts.append(start)
        found = solve(problem, start, replace(options, max_iterations=2))
        return replace(found, cost=found.cost[:1]) if len(starts) == 2 else found

    monkeypatch.setattr("robotid.report.evidence.profile.solve", sticking)
    monkeypatch.setattr("robotid.report.evidence.profile.MAX_REFITS", 1)
    profile_intervals(fit, (record,), None)
    values = [p.value for p in fit.parameters if p.name != "motor.stribeck.vs"]
    assert starts[1][:4] != pytest.approx(values, rel=0.02)
    assert starts[2][:4] == pytest.approx(values, rel=0.02)


def test_a_profile_whose_cost_does_not_rise_has_no_end(monkeypatch: pytest.MonkeyPatch) -> None:
    record, fit = slippery()
    refits: list[Solution] = []

    def flat(problem: OutputError, start: Array, options: SolveOptions) -> Solution:
        if refits:
            return replace(refits[0], cost=(2.0, 1.0))
        refits.append(solve(problem, start, options))
        return refits[0]

    monkeypatch.setattr("robotid.report.evidence.profile.solve", flat)
    unbounded = tuple(replace(p, lower=-1e9, upper=1e9) for p in fit.parameters)
    found = profile_intervals(replace(fit, parameters=unbounded), (record,), None)
    assert set(found.without.values()) == {NO_END}


def test_a_residual_of_few_independent_samples_has_no_profile() -> None:
    record, fit = slippery()
    least = np.sqrt(len(record) / len(fit.parameters))  # as many independent samples as parameters
    for more, given in ((0.9, True), (1.1, False)):
        coloured = replace(fit, parameters=tuple(replace(p, std=p.std_robust / (least * more)) for p in fit.parameters))
        without = profile_intervals(coloured, (record,), None).without
        assert any("independent samples" in why for why in without.values()) is not given


def test_a_profile_gives_up_what_is_simulated_too_slowly(monkeypatch: pytest.MonkeyPatch) -> None:
    record, fit = slippery()
    patience: list[int | None] = []

    def spied(problem: OutputError, start: Array, options: SolveOptions) -> Solution:
        patience.append(problem.max_failed_windows)
        if len(patience) > 1:
            raise NumericsError("the simulation settles too slowly to be of use")
        return solve(problem, start, options)

    monkeypatch.setattr("robotid.report.evidence.profile.solve", spied)
    found = profile_intervals(fit, (record,), None)
    names = [p.name for p in doubtful(fit)]
    assert patience == [None, *[REFIT.patience] * 2 * len(names)]  # from where the linear model leads, and from the fit
    assert (found.intervals, list(found.without)) == ({}, names)
    note = parameter_table("m", fit, {}, found).note
    assert f"no profile interval of {listed(names, 'or')}: with it elsewhere the model is simulated much more" in note


def test_a_profile_gives_up_refits_that_settle_worse_than_the_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    record, fit = slippery()
    refits: list[Solution] = []

    def settling(problem: OutputError, start: Array, options: SolveOptions) -> Solution:
        found = solve(problem, start, options)
        if problem.max_failed_windows is None:
            return found
        worse = tuple(replace(one, failed_windows=9) for one in found.evaluation.trajectories)
        refits.append(replace(found, evaluation=replace(found.evaluation, trajectories=worse)))
        return refits[-1]

    monkeypatch.setattr("robotid.report.evidence.profile.solve", settling)
    found = profile_intervals(fit, (record,), None)
    assert (found.intervals, len(refits)) == ({}, 2 * len(doubtful(fit)))  # from two starts each


def test_a_fit_that_is_better_elsewhere_has_no_profile(monkeypatch: pytest.MonkeyPatch) -> None:
    record, fit = slippery()

    def stopping(problem: OutputError, start: Array, options: SolveOptions) -> Solution:
        stop = problem.max_failed_windows is None
        return solve(problem, 1.1 * start if stop else start, replace(options, max_iterations=0) if stop else options)

    monkeypatch.setattr("robotid.report.evidence.profile.solve", stopping)
    found = profile_intervals(fit, (record,), None)
    assert found.intervals == {}
    (why,) = set(found.without.values())
    assert why.startswith("the fit is better with motor.")


def test_too_many_samples_for_a_page_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    record, fit = slippery()
    monkeypatch.setattr("robotid.report.evidence.profile.MAX_SAMPLES", len(record) - 1)
    found = profile_intervals(fit, (record,), None)
    assert list(found.without) == [p.name for p in doubtful(fit)]


def test_an_interval_that_is_not_symmetric_is_told_in_the_table() -> None:
    record, fit = slippery()
    found = profile_intervals(fit, (record,), None)
    rows = {row[0]: row for row in parameter_table("m", fit, {}, found).rows}
    for p in fit.parameters:
        row, interval = rows[p.name], found.intervals.get(p.name)
        assert bool(row[5]) == (interval is not None)
        assert ("not symmetric" in row[-1]) == (interval is not None and not interval.symmetric)
    assert any(not interval.symmetric for interval in found.intervals.values())


@cache
def pose_dependent() -> Findings:
    """What a motor lacks whose inertia follows the sine of another axis' angle."""
    made, f = record(), findings()
    assert f.diagnosis is not None
    q2 = made.companions["q2"].values
    lacking = 0.02 * np.sin(q2) * np.gradient(made.dphi_m, made.sampling_time)
    noise = 0.05 * np.random.default_rng(3).standard_normal(len(made))
    missing = {made.name: Trace(made.t, lacking + noise, lacking, "Nm")}
    causes = (replace(f.diagnosis.causes[0], effect="motor.pose_inertia[q2]"),)
    diagnosis = replace(f.diagnosis, missing=missing, causes=causes, shape=None)
    return replace(f, recordings=Recordings((made,)), diagnosis=diagnosis, validation=None, extension=None)


def test_the_missing_torque_along_a_companion_is_counted_as_it_is_ordered_best() -> None:
    first, *others = companion_curves(pose_dependent())
    assert (first.along, first.unit) == ("companion[q2], by acceleration", "rad")
    np.testing.assert_allclose(first.missing_torque, 0.02 * np.sin(first.x) * first.at, atol=0.05)
    assert first.order > 0.3
    assert all(one.order < 0.1 * first.order for one in others)  # an inertia that does not follow them is no sign of it
    assert {one.along.partition("]")[0] for one in others} >= {"companion[q3", "companion[gear", "companion[bus"}


def test_a_cause_that_reads_a_companion_is_drawn_along_it() -> None:
    specs = [spec for spec in figure_specs(pose_dependent()) if "companion" in spec.name]
    shown = next(spec for spec in specs if not spec.folded)
    assert shown.name == "misfit-companion-q2-by-acceleration"
    assert len(shown.bins) > 5
    figure = shown.draw()
    assert figure.axes[0].get_xlabel() == "q2 [rad]"
    assert "in proportion to acceleration" in figure.axes[0].get_ylabel()
    figure.canvas.draw()
    label = figure.axes[0].yaxis.label.get_window_extent()
    assert figure.bbox.y0 <= label.y0 < label.y1 <= figure.bbox.y1
    assert "the q2" not in shown.alt
    drawn_curves = curves(figure)
    before, after = drawn_curves["asked for, before"], drawn_curves["still asked for, after"]
    assert np.abs(after).max() < 0.2 * np.abs(before).max()
    assert sum(spec.folded for spec in specs) >= 5


def test_what_a_variable_tells_beyond_another() -> None:
    """Friction at small speed on a motor that reverses at two places: the angle orders the torque, too, and tells
    nothing that the speed does not; a ripple along the angle it tells alone."""
    phase = np.linspace(0.0, 40 * np.pi, 40_000)
    speed, angle = np.cos(phase), np.sin(phase)
    friction = np.sign(speed) * np.exp(-((speed / 0.1) ** 2))
    block = (np.arange(len(phase)) * 20) // len(phase)
    along = {
        name: Binned(np.minimum(((values + 1) * 30).astype(np.intp), 59), np.ones(len(phase)), 60)
        for name, values in (("speed", speed), ("angle", angle), ("nothing", np.zeros(len(phase))))
    }
    assert beyond(friction**2, along["nothing"], along["angle"], block) > 0.25
    assert beyond(friction**2, along["speed"], along["angle"], block) < 0.02
    rippled = friction**2 + 0.5 * np.sin(8 * angle)
    assert beyond(rippled, along["speed"], along["angle"], block) > 0.3
    assert beyond(np.zeros(len(phase)), along["speed"], along["angle"], block) == 0.0
