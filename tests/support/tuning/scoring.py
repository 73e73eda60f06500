"""Checks of the constants of the score."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.diagnosis.noise.whitening import UNIT_WHITENING
from robotid.diagnosis.refit.refitted_model import Unknowns
from robotid.diagnosis.scoring import periods
from robotid.diagnosis.scoring.catalogue_candidates import term_candidate
from robotid.diagnosis.scoring.confounding import confounded_with
from robotid.diagnosis.scoring.periods import Wave, period_peaks
from robotid.diagnosis.scoring.projection import project
from robotid.diagnosis.scoring.resonances import Drive, _cross_spectrum, resonance_peaks
from robotid.diagnosis.scoring.scan import Scan
from robotid.diagnosis.scoring.score_test import score
from robotid.diagnosis.scoring.settings import SCORING
from robotid.model.array import Array
from robotid.model.port import Port
from robotid.terms import TERMS
from support.plain_models import SAMPLES, plain_segment
from support.tuning import sees

ANGLE = np.linspace(0.0, 40 * np.pi, 20_000)  # twenty turns
RESOLUTION = 1 / 20  # periods a turn


def peaks(weight: Array, grid: tuple[float, ...] = (1.0, 12.0)) -> list[float]:
    return list(period_peaks([Wave(ANGLE, weight)], grid))


def scanned(rows: Array, fitted: int) -> Scan:
    """A segment with these signals, the first of them of fitted parameters."""
    segment = plain_segment(0.0, samples=rows.shape[1])
    return Scan(segment, UNIT_WHITENING, Unknowns("speed", tuple(range(fitted))), rows)


@sees(SCORING, "dependent")
def check_a_column_of_which_a_hundred_thousandth_is_left_is_not_scored() -> None:
    candidate = term_candidate(Port.MOTOR, TERMS["quadratic_friction"], (0.0,))

    def energy(left: float) -> float:
        own, other = np.eye(8)[:2]
        rows = np.stack([own, own + left * other, other])
        return score(project([scanned(rows, 1)]), [candidate])[0].energy

    assert energy(1.5e-5) == pytest.approx(1.0)
    assert energy(0.7e-5) == 0.0


@sees(SCORING, "confounded")
def check_answers_are_alike_from_a_correlation_of_seven_tenths() -> None:
    terms = TERMS["quadratic_friction"], TERMS["asymmetric_coulomb"]
    both = [term_candidate(Port.MOTOR, term, (0.0,)) for term in terms]

    def alike(correlation: float) -> int:
        own, other = np.eye(8)[:2]
        rows = np.stack([own, correlation * own + np.sqrt(1 - correlation**2) * other, own])
        projected = project([scanned(rows, 0)])
        best, *others = score(projected, both)
        return len(confounded_with(best, projected, (best, *others)))

    assert (alike(0.72), alike(0.68)) == (1, 0)


@sees(SCORING, "negligible")
def check_what_differs_by_a_hundred_thousandth_explains_nothing_of_its_own() -> None:
    def left(apart: float) -> float:
        own, other = np.eye(8)[:2]
        rows = np.stack([own, own + apart * other, other])
        return float(np.linalg.norm(scanned(rows, 0).unexplained().residual))

    # the smaller of the two squared singular values of columns at an angle is half the angle squared, of nearly two
    assert left(1.5 * 2e-5) < 1e-3
    assert left(0.7 * 2e-5) > 0.9


@sees(SCORING, "period_peaks")
def check_three_periods_are_tried() -> None:
    waves = sum(np.cos(n * ANGLE) / k for k, n in enumerate((2.0, 4.0, 6.0, 8.0, 10.0), start=1))
    noise = np.random.default_rng(2).standard_normal(len(ANGLE))
    found = peaks(np.asarray(waves) + 0.3 * noise)
    assert {n for n in (2.0, 4.0, 6.0, 8.0, 10.0) if min(abs(np.array(found) - n)) < RESOLUTION / 2} == {2.0, 4.0, 6.0}


def bins_of(span: float, highest: float) -> int:
    """Into how many bins a motion is divided."""
    used, count = list[int](), np.bincount
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(periods.np, "bincount", lambda at, weight, bins: used.append(bins) or count(at, weight, bins))
        list(period_peaks([Wave(np.linspace(0.0, span, 999), np.ones(999))], (1.0, highest)))
    return used[0] if used else 0


@sees(SCORING, "bins_a_period")
def check_the_shortest_period_has_sixteen_bins() -> None:
    assert bins_of(2 * np.pi, 8.0) == 128


@sees(SCORING, "zero_padding")
def check_a_spectrum_has_four_points_in_its_resolution() -> None:
    found = np.array(peaks(np.cos(5.0 * ANGLE)))
    assert np.diff(found).min() == pytest.approx(RESOLUTION / 4)


@sees(SCORING, "peak_shift")
def check_the_neighbours_of_a_high_peak_are_tried() -> None:
    found = np.array(peaks(np.cos(5.0 * ANGLE)))
    near = found[np.abs(found - 5.0) < 0.9 * RESOLUTION]
    assert len(near) == 3


@sees(SCORING, "max_spectrum_points")
def check_motions_of_too_many_turns_are_left_to_the_grid() -> None:
    turns = 2**21 / 4 / 16  # of one period each
    assert bins_of(0.9 * turns * 2 * np.pi, 1.0) == 2**19
    assert bins_of(1.1 * turns * 2 * np.pi, 1.0) == 0


@sees(SCORING, "peak_surroundings")
def check_a_prominent_peak_stands_out_from_a_hundred_points() -> None:
    used, median = list[int](), periods.median_filter
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(periods, "median_filter", lambda x, size: used.append(size) or median(x, size))
        peaks(np.cos(5.0 * ANGLE))
    # in numbers of periods, what a peak is compared with spans somewhat more than one
    assert used[0] * RESOLUTION / 4 == pytest.approx(1.25, rel=0.05)


def drive() -> Drive:
    """What rings at many frequencies."""
    rng = np.random.default_rng(3)
    speed = rng.standard_normal(4000)
    return Drive(speed, np.convolve(speed, rng.standard_normal(60))[:4000], 1e-3)


def narrow(frequency: float):  # type: ignore[no-untyped-def]
    return lambda omega: 1.0 / (frequency**2 - omega**2 + 2j * 0.005 * frequency * omega)


@sees(SCORING, "resonance_peaks")
def check_two_resonances_are_tried() -> None:
    assert len(resonance_peaks([drive()], narrow, (20.0, 400.0), False)) == 2


@sees(SCORING, "resonance_points")
def check_two_hundred_frequencies_are_compared() -> None:
    asked = list[float]()

    def response(frequency: float):  # type: ignore[no-untyped-def]
        asked.append(frequency)
        return narrow(frequency)

    resonance_peaks([drive()], response, (20.0, 400.0), False)
    # as close as the half widths of a resonance of one per cent damping
    assert asked[1] / asked[0] == pytest.approx(1.015, abs=0.004)


@sees(SCORING, "resonance_range")
def check_a_resonance_is_compared_up_to_twice_its_highest_frequency() -> None:
    seen = list[Array]()

    def response(_: float):  # type: ignore[no-untyped-def]
        return lambda omega: seen.append(omega) or np.ones(len(omega))

    resonance_peaks([drive()], response, (20.0, 400.0), False)
    assert seen[0][-1] == pytest.approx(800.0, rel=0.01)
    assert len(_cross_spectrum([drive()], 800.0)[0]) == len(seen[0])


@sees(SCORING, "blocks")
def check_records_are_cut_into_forty_blocks() -> None:
    segment = plain_segment(1.0)
    wave = np.sin(np.arange(SAMPLES))
    one = Scan(segment, UNIT_WHITENING, Unknowns("speed"), np.stack([wave, segment.residual]))
    assert project([one]).blocks.count == 40
