"""How much of each noise a residual shows.

The spectrum of a residual is a sum of shapes that are known up to their levels; the levels are those of Whittle's
likelihood (Whittle 1953). A residual of an angle falls by many powers of ten from one end of its spectrum to the other,
and leaks. It is therefore whitened by the levels found so far before its spectrum is taken, the shapes are filtered
alike, and this is repeated until the levels stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import nnls

from robotid.estimate.noise.lines import Innovations, Residual, band_edges, band_means
from robotid.estimate.noise.settings import SETTINGS, SMALLEST, LevelSettings
from robotid.estimate.noise.whitening import InnovationsFilter, NoiseLevels, innovations_filter
from robotid.model.array import Array

KINSHIP = 35 / 18  # neighbouring frequencies per independent one under a Hann taper
SCORING, PRECISION, TIE = 30, 1e-8, 1e-12  # steps of Fisher scoring, relative change at its end, of equal spectra


def fit_levels(residuals: Sequence[Residual], settings: LevelSettings = SETTINGS) -> tuple[NoiseLevels, ...]:
    """Noise levels of every residual: an output noise of its own, and the torque's in common.

    The red noise, and the white one on the torque, count only where the Bayesian information criterion asks for them.
    """
    levels = _start(residuals, settings)
    if not any(one.signal.any() for one in residuals):
        return levels
    for _ in range(settings.sweeps):
        after = _refine(residuals, levels, settings)
        done = all(_alike(a, b, settings.settled) for a, b in zip(levels, after, strict=True))
        levels = after
        if done:
            break
    return levels


def likely_levels(
    residuals: Sequence[Residual], levels: Sequence[NoiseLevels], settings: LevelSettings = SETTINGS
) -> list[tuple[float, tuple[NoiseLevels, ...]]]:
    """Levels that explain residuals about as well as the likeliest, with the share of belief in each.

    Short records hardly tell the memory of the torque's noise, and an interval is as long as that is: a mean over the
    corners is fairer than the best of them (Hoeting et al. 1999). levels : the likeliest.
    """
    if not any(one.signal.any() for one in residuals):
        return [(1.0, tuple(levels))]
    choices = _choices(residuals, levels, settings)
    least = min(criterion for criterion, _ in choices)
    weighed = [(float(np.exp(-0.5 * (criterion - least))), one) for criterion, one in choices]
    kept = [(weight, one) for weight, one in weighed if weight > settings.believable]
    total = sum(weight for weight, _ in kept)
    return [(weight / total, one) for weight, one in kept]


def expected_levels(
    residuals: Sequence[Residual], levels: Sequence[NoiseLevels], settings: LevelSettings = SETTINGS
) -> tuple[NoiseLevels, ...]:
    """The levels with the torque's noise as large as it is on average over what the residuals leave open.

    Short records tell the torque's noise from that of the output poorly, and the likeliest level is then often none,
    which would make an interval far too small. The mean is over the likelihood, the standard deviation of the noise
    beforehand as likely at any value (Gelman 2006).
    """
    filters = [innovations_filter(one.response, level) for one, level in zip(residuals, levels, strict=True)]
    silent = levels[0].torque + levels[0].red == 0.0
    shape = replace(levels[0], torque=1.0) if silent else levels[0]
    parts = [_shares(one, whiten, shape, settings) for one, whiten in zip(residuals, filters, strict=True)]
    scales = _scales(parts, shape, silent=silent, settings=settings)
    most = min(one.most_torque for one in residuals) / max(shape.torque, SMALLEST)
    scales = scales[scales <= most] if np.any(scales <= most) else np.array([most])
    costs = []
    for scale in scales:
        found = [_output_beside(part, scale) for part in parts]
        costs.append(sum(cost for _, cost in found))
    # Evenly spaced in the logarithm, a standard deviation that is likely at any value weighs with its own size.
    weights = np.sqrt(scales) * np.exp(-0.5 * (np.array(costs) - min(costs)))
    mean = float(weights @ scales / weights.sum()) if weights.any() else 0.0  # a constant torque has no noise
    outputs = [_output_beside(part, mean)[0] for part in parts]
    return tuple(
        replace(shape, output=max(output, one.least), torque=mean * shape.torque, red=mean * shape.red)
        for output, one in zip(outputs, residuals, strict=True)
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Shares:
    """Whitened periodogram (f,), and what the output's noise of unit variance and the torque's as it is assumed would
    add to it, (f,) each; count as of `_Lines`."""

    power: Array
    output: Array
    torque: Array
    count: Array


def _shares(one: Residual, whiten: InnovationsFilter, shape: NoiseLevels, settings: LevelSettings) -> _Shares:
    innovations = Innovations.of(one, whiten, settings)
    white, red = innovations.of_the_torque(one, np.array([shape.corner]))
    torque = shape.torque * white + shape.red * red[0]
    edges = band_edges(len(torque), settings)
    power, output, torque = (band_means(one, edges) for one in (innovations.power, innovations.gain, torque))
    return _Shares(power, output, torque, np.diff(np.append(edges, len(innovations.power))).astype(np.float64))


def _scales(parts: Sequence[_Shares], shape: NoiseLevels, *, silent: bool, settings: LevelSettings) -> Array:
    """Factors on the torque's noise that are tried, about one or, where none was found, about what can just be seen."""
    centre, seen = 1.0, [part for part in parts if part.torque.any()]  # a motor that is held shows no torque
    if silent and seen:
        centre = float(np.median([np.mean(part.power) / np.max(part.torque) for part in seen]))
    return np.asarray(centre * np.geomspace(10.0**-settings.reach, 10.0**settings.reach, settings.scales))


def _output_beside(part: _Shares, scale: float) -> tuple[float, float]:
    """The likeliest variance of the output's noise beside so much of the torque's, and minus twice the logarithm of the
    likelihood; by Fisher scoring of one level."""
    beside = scale * part.torque
    level = max(float(np.median(part.power / part.output)), SMALLEST)
    for _ in range(SCORING):
        model = level * part.output + beside
        weight = part.count * (part.output / model) ** 2
        after = max(float(weight @ ((part.power - beside) / part.output) / weight.sum()), TIE * level)
        done = abs(after - level) <= PRECISION * level
        level = after
        if done:
            break
    model = level * part.output + beside
    return level, 2 / KINSHIP * float(part.count @ (np.log(model) + part.power / model))


def _start(residuals: Sequence[Residual], settings: LevelSettings) -> tuple[NoiseLevels, ...]:
    """The output noise by the finest differences, and the torque's white noise that makes the innovations likeliest."""
    outputs = [
        max(one.least, float(np.median(np.diff(one.sensed, 2) ** 2)) / (0.455 * 6.0), 1e-300) for one in residuals
    ]
    best, cost = tuple(NoiseLevels(output) for output in outputs), np.inf
    n = max(len(one.signal) for one in residuals)
    for omega in 2 * np.pi * np.geomspace(1 / n, 0.5, settings.crossings):
        ratios = [o / one.response.squared(np.array([omega]))[0] for o, one in zip(outputs, residuals, strict=True)]
        torque = float(np.median(ratios))
        tried = tuple(NoiseLevels(output, torque) for output in outputs)
        value = sum(_unlikelihood(one, level) for one, level in zip(residuals, tried, strict=True))
        if value < cost:
            best, cost = tried, value
    return best


def _unlikelihood(one: Residual, levels: NoiseLevels) -> float:
    """Minus twice the logarithm of the innovations' likelihood."""
    whiten = innovations_filter(one.response, levels)
    innovations = whiten(one.signal)
    first = whiten.sections[:, 0].prod() / whiten.sections[:, 3].prod()
    return float(innovations @ innovations) - 2.0 * len(innovations) * float(np.log(abs(first)))


def _alike(a: NoiseLevels, b: NoiseLevels, settled: float) -> bool:
    pairs = ((a.output, b.output), (a.torque, b.torque), (a.red, b.red))
    return all(abs(x - y) <= settled * max(x, y) for x, y in pairs) and (a.red == 0.0 or a.corner == b.corner)


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """Whitened periodogram (f,) of a residual, and what each noise of unit variance would add to it.

    output, torque (f,), red (corners, f). count : (f,) how many neighbouring frequencies each is the mean of."""

    power: Array
    output: Array
    torque: Array
    red: Array
    count: Array


def _refine(
    residuals: Sequence[Residual], levels: Sequence[NoiseLevels], settings: LevelSettings
) -> tuple[NoiseLevels, ...]:
    """The choice that the criterion asks for."""
    return min(_choices(residuals, levels, settings), key=lambda one: one[0])[1]


def _choices(
    residuals: Sequence[Residual], levels: Sequence[NoiseLevels], settings: LevelSettings
) -> list[tuple[float, tuple[NoiseLevels, ...]]]:
    """The likeliest levels with and without noise on the torque, white, and red of every corner, each with the
    criterion of Bayes. levels : by which the residuals are whitened."""
    corners = _corners(residuals, settings)
    filters = [innovations_filter(one.response, level) for one, level in zip(residuals, levels, strict=True)]
    lines = [_lines(one, whiten, corners, settings) for one, whiten in zip(residuals, filters, strict=True)]
    power = np.concatenate([one.power for one in lines])
    own = np.zeros((len(lines), len(power)))
    first = 0
    for k, one in enumerate(lines):
        own[k, first : first + len(one.power)] = one.output
        first += len(one.power)
    torque, red = (np.concatenate([getattr(one, name) for one in lines], axis=-1) for name in ("torque", "red"))
    choices: list[tuple[Array, bool, int | None]] = [(own, False, None), (np.vstack([own, torque]), True, None)]
    choices += [(np.vstack([own, torque, red[i : i + 1]]), True, i) for i in range(len(corners))]
    count = np.concatenate([one.count for one in lines])
    sizes = [float(np.mean(one.sensed**2)) for one in residuals]
    n, answer = len(lines), []
    for bases, white, at in choices:
        found, cost = whittle(power, bases, count)
        these = tuple(
            NoiseLevels(
                max(float(found[k]), one.least, TIE * size + SMALLEST),
                min(float(found[n]), one.most_torque) if white else 0.0,
                float(found[n + 1]) if at is not None else 0.0,
                float(corners[at]) if at is not None else 1.0,
            )
            for k, (one, size) in enumerate(zip(residuals, sizes, strict=True))
        )
        answer.append((cost + len(bases) * float(np.log(count.sum())), these))
    return answer


def _corners(residuals: Sequence[Residual], settings: LevelSettings) -> Array:
    """Corners of the red noise that are tried [rad/s]: from the slowest that a record can tell to a tenth of the
    sampling rate."""
    h = min(one.response.sampling_time for one in residuals)
    longest = max(len(one.signal) * one.response.sampling_time for one in residuals)
    low, high = 2 * np.pi / longest, 2 * np.pi * 0.1 / h
    count = max(1, int(np.log(high / low) / np.log(settings.corner_step)) + 1) if high > low else 1
    return np.asarray(low * settings.corner_step ** np.arange(count))


def _lines(one: Residual, whiten: InnovationsFilter, corners: Array, settings: LevelSettings) -> _Lines:
    innovations = Innovations.of(one, whiten, settings)
    torque, red = innovations.of_the_torque(one, corners)
    edges = band_edges(len(torque), settings)
    power, output, torque, red = (band_means(one, edges) for one in (innovations.power, innovations.gain, torque, red))
    return _Lines(power, output, torque, red, np.diff(np.append(edges, len(innovations.power))).astype(np.float64))


def whittle(power: Array, bases: Array, lines: Array | None = None) -> tuple[Array, float]:
    """Levels of spectra that explain a periodogram best, and minus twice the logarithm of their likelihood.

    power (f,), bases (k, f) -> (k,), none negative. lines : (f,) how many neighbouring frequencies each is the mean of.
    Fisher scoring, each step a least-squares problem with non-negative unknowns.
    """
    count = np.ones(len(power)) if lines is None else lines
    size = bases.mean(axis=1, keepdims=True)
    size[size <= 0.0] = 1.0
    bases = bases / size
    model, least, before = np.full(len(power), power.mean()), 1e-12 * power.mean() + SMALLEST, np.zeros(len(bases))
    for _ in range(SCORING):
        weighted = np.sqrt(count) * bases / model
        levels, _ = nnls(weighted.T, np.sqrt(count) * power / model)
        model = np.maximum(levels @ bases, least)
        if np.abs(levels - before).max() <= PRECISION * levels.max():
            break
        before = levels
    return levels / size[:, 0], 2 / KINSHIP * float(count @ (np.log(model) + power / model))
