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
from scipy.linalg import lstsq
from scipy.optimize import nnls

from robotid.estimate.noise.lines import Innovations, Residual, band_edges, band_means
from robotid.estimate.noise.settings import SETTINGS, SMALLEST, LevelSettings
from robotid.estimate.noise.whitening import NoiseLevels, innovations_filter
from robotid.model.array import Array, Index
from robotid.parallel import each

KINSHIP = 35 / 18  # neighbouring frequencies per independent one under a Hann taper: exact, no tuning
OF_THE_TORQUE = 3  # parameters of its noise: white, red, and the memory of the red one
SCORING, PRECISION, TIE = 30, 1e-8, 1e-12  # steps of Fisher scoring, relative change at its end, of equal spectra
TURNS = 20  # by which it is found which levels are zero; two or three nearly always do


def fit_levels(
    residuals: Sequence[Residual], settings: LevelSettings = SETTINGS, near: Sequence[NoiseLevels] | None = None
) -> tuple[NoiseLevels, ...]:
    """Noise levels of every residual: an output noise of its own, and the torque's in common.

    The red noise, and the white one on the torque, count only where the Bayesian information criterion asks for them.
    near : levels to whiten by first, where some are known. A residual that is zero throughout, as of a motor that rests
    where its simulation does, tells of no noise, and has the torque's of the others.
    """
    telling = [k for k, one in enumerate(residuals) if one.signal.any()]
    if 0 < len(telling) < len(residuals):
        seen = _fitted((residuals, settings, near), telling)
        found = dict(zip(telling, seen, strict=True))
        silent = (replace(seen[0], output=max(one.least, SMALLEST)) for one in residuals)
        return tuple(found.get(k, one) for k, one in enumerate(silent))
    levels = _start(residuals, settings) if near is None else tuple(near)
    if not telling:
        return levels
    for _ in range(settings.sweeps):
        after = _refine(residuals, levels, settings)
        done = all(_alike(a, b, settings.settled) for a, b in zip(levels, after, strict=True))
        levels = after
        if done:
            break
    return levels


def fit_levels_by_record(
    residuals: Sequence[Residual],
    records: Sequence[str],
    settings: LevelSettings = SETTINGS,
    near: Sequence[NoiseLevels] | None = None,
) -> tuple[NoiseLevels, ...]:
    """The same with errors of the torque of each record's own, where the Bayesian information criterion asks for them:
    what a measured current is wrong by often grows with it. records : of which one each residual is, by name."""
    every = tuple(range(len(residuals)))
    of_each = [tuple(k for k in every if records[k] == name) for name in dict.fromkeys(records)]
    parts = [every, *of_each] if len(of_each) > 1 else [every]
    samples = sum(len(one.signal) for one in residuals)
    common, *apart = each(_fitted, (residuals, settings, near), parts, samples=samples)
    if not apart:
        return common
    own = list(common)
    for at, found in zip(of_each, apart, strict=True):
        for k, levels in zip(at, found, strict=True):
            own[k] = levels
    costs = [sum(map(_unlikelihood, residuals, levels)) for levels in (common, own)]
    further = OF_THE_TORQUE * (len(of_each) - 1) * float(np.log(samples))
    return tuple(own) if costs[1] + further < costs[0] else common


def _fitted(
    shared: tuple[Sequence[Residual], LevelSettings, Sequence[NoiseLevels] | None], at: Sequence[int]
) -> tuple[NoiseLevels, ...]:
    """The levels of those of the residuals that have these numbers."""
    residuals, settings, near = shared
    return fit_levels([residuals[k] for k in at], settings, None if near is None else [near[k] for k in at])


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
    found = choices(residuals, whitened(residuals, levels, settings), settings)
    return min(found, key=lambda one: one.criterion).levels


def whitened(
    residuals: Sequence[Residual], levels: Sequence[NoiseLevels], settings: LevelSettings = SETTINGS
) -> list[Innovations]:
    """Residuals, each whitened by its levels."""
    pairs = zip(residuals, levels, strict=True)
    return [Innovations.of(one, innovations_filter(one.response, level), settings) for one, level in pairs]


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """Noises that may make residuals, at their likeliest levels; criterion : of Bayes. shape : the root of what the
    whitened spectra tell of the logarithm of the red noise's corner, all levels free, and one without such a noise;
    at_end : whether this corner is the first or the last, None without such a noise."""

    criterion: float
    levels: tuple[NoiseLevels, ...]
    shape: float = 1.0
    at_end: bool | None = None


def choices(residuals: Sequence[Residual], seen: Sequence[Innovations], settings: LevelSettings) -> list[Choice]:
    """Without noise on the torque, with white, and with red of every corner besides. seen : whitened residuals."""
    corners = corners_of(residuals, settings)
    lines = [_lines(one, by, corners, settings) for one, by in zip(residuals, seen, strict=True)]
    power, white, red, count = (
        np.concatenate([getattr(one, name) for one in lines], axis=-1) for name in ("power", "torque", "red", "count")
    )
    n, of = len(lines), np.repeat(np.arange(len(lines)), [len(one.power) for one in lines])
    own = np.concatenate([one.output for one in lines]) * (of == np.arange(n)[:, None])
    slopes = np.zeros(red.shape)
    if len(corners) > 1:
        slopes = np.gradient(red, np.log(corners), axis=0, edge_order=2 if len(corners) > 2 else 1)
    least = np.array([max(one.least, TIE * float(np.mean(one.sensed**2)) + SMALLEST) for one in residuals])
    most = np.array([one.most_torque for one in residuals])
    options: list[tuple[Array, Array, int | None]] = [(own, np.zeros(n), None), (np.vstack([own, white]), most, None)]
    options += [(np.vstack([own, white, red[i : i + 1]]), most, i) for i in range(len(corners))]
    answer = []
    for bases, caps, at in options:
        found, cost = _bounded(power, bases, count, of, least, caps)
        reds = found[n + 1] if at is not None else np.zeros(n)
        corner = float(corners[at]) if at is not None else 1.0
        pairs = zip(found[:n].diagonal(), found[n] if len(found) > n else np.zeros(n), reds, strict=True)
        these = tuple(NoiseLevels(float(output), float(torque), float(slow), corner) for output, torque, slow in pairs)
        criterion = cost + len(bases) * float(np.log(count.sum()))
        if at is None:
            answer.append(Choice(criterion, these))
            continue
        shape = _root_information(found[:, of] * bases, reds[of] * slopes[at], count)
        answer.append(Choice(criterion, these, shape, at in (0, len(corners) - 1)))
    return answer


def _bounded(power: Array, bases: Array, count: Array, of: Index, least: Array, most: Array) -> tuple[Array, float]:
    """The likeliest level of every noise in every residual, (k, n), and minus twice the logarithm of its likelihood.

    bases : (k, f), the output's noises of the n residuals, then the torque's white one, then its red one; of : (f,) to
    which residual a line belongs; least : (n,) of the output's noise; most : (n,) of the torque's white one. What is at
    its bound stays there while the others are sought: cut off afterwards, it would have taken what is theirs.
    """
    n, free = len(least), bases.copy()
    levels, at_most = np.zeros((len(bases), n)), np.zeros(n, dtype=np.bool_)
    apart = _apart(of, n) if n > 1 else None
    levels[:n] = np.diag(least)
    while True:
        fixed = (levels[:, of] * bases).sum(axis=0)
        found, cost = whittle(power, free, count, fixed, apart)
        over = ~at_most & (found[n] > most) if len(bases) > n else np.zeros(n, dtype=np.bool_)
        if not over.any():
            break
        at_most |= over
        levels[n, over], free[n, over[of]] = most[over], 0.0
    levels[:n] += np.diag(found[:n])
    levels[n:] += found[n:, None]
    levels[n : n + 1, at_most] = most[at_most]
    return levels, cost


def _root_information(parts: Array, slope: Array, count: Array) -> float:
    """Root of Fisher's information on what changes a spectrum by a slope (f,), the levels of its parts (k, f) free.

    Whittle (1953): of the logarithm of a spectrum every independent line tells one.
    """
    model = np.maximum(parts.sum(axis=0), SMALLEST)
    roots = np.sqrt(count / KINSHIP) / model
    weighted, along = parts[parts.any(axis=1)] * roots, slope * roots
    taken, *_ = lstsq(weighted.T, along, lapack_driver="gelsy")  # of gelsd singular values may fail to converge
    left = along - taken @ weighted
    return float(np.linalg.norm(left))


def corners_of(residuals: Sequence[Residual], settings: LevelSettings) -> Array:
    """Corners of the red noise that are tried [rad/s]: from the slowest that a record can tell to a tenth of the
    sampling rate."""
    h = min(one.response.sampling_time for one in residuals)
    longest = max(len(one.signal) * one.response.sampling_time for one in residuals)
    low, high = 2 * np.pi / longest, 2 * np.pi * 0.1 / h
    count = max(1, int(np.log(high / low) / np.log(settings.corner_step)) + 1) if high > low else 1
    return np.asarray(low * settings.corner_step ** np.arange(count))


def _lines(one: Residual, innovations: Innovations, corners: Array, settings: LevelSettings) -> _Lines:
    torque, red = innovations.of_the_torque(one, corners)
    edges = band_edges(len(torque), settings)
    power, output, torque, red = (band_means(one, edges) for one in (innovations.power, innovations.gain, torque, red))
    return _Lines(power, output, torque, red, np.diff(np.append(edges, len(innovations.power))).astype(np.float64))


def whittle(
    power: Array,
    bases: Array,
    lines: Array | None = None,
    fixed: Array | float = 0.0,
    apart: Index | None = None,
) -> tuple[Array, float]:
    """Levels of spectra that explain a periodogram best, and minus twice the logarithm of their likelihood.

    power (f,), bases (k, f) -> (k,), none negative. lines : (f,) how many neighbouring frequencies each is the mean of;
    fixed : (f,) what is there besides; apart : as of `_apart`, where the first bases are of one residual each. Fisher
    scoring, each step a least-squares problem with non-negative unknowns.
    """
    count = np.ones(len(power)) if lines is None else lines
    size = bases.mean(axis=1, keepdims=True)
    size[size <= 0.0] = 1.0
    bases = bases / size
    model, least, before = np.full(len(power), power.mean()), 1e-12 * power.mean() + SMALLEST, np.zeros(len(bases))
    for _ in range(SCORING):
        weighted, aim = np.sqrt(count) * bases / model, np.sqrt(count) * (power - fixed) / model
        levels = nnls(weighted.T, aim)[0] if apart is None else _apart_levels(weighted, aim, apart)
        model = np.maximum(levels @ bases + fixed, least)
        if np.abs(levels - before).max() <= PRECISION * levels.max():
            break
        before = levels
    return levels / size[:, 0], 2 / KINSHIP * float(count @ (np.log(model) + power / model))


def _apart(of: Index, n: int) -> Index:
    """The lines of each of n residuals, (n, lines of the longest), -1 where there are no more. of : as of
    `_bounded`."""
    lines = [np.flatnonzero(of == k) for k in range(n)]
    found = np.full((len(lines), max(map(len, lines))), -1)
    for row, own in zip(found, lines, strict=True):
        row[: len(own)] = own
    return found


def _apart_levels(weighted: Array, aim: Array, apart: Index) -> Array:
    """The least squares of columns (k, f) to an aim (f,), no level (k,) negative, the first columns being of one
    residual each.

    The lines of a residual are turned into as many rows as columns concern them (Golub & Van Loan 2013, section 5.3),
    of which the first alone holds its own column. So the common levels are those of all other rows, and of the first
    ones of residuals whose own level is zero; which these are is found by turns (Hintermueller, Ito & Kunisch 2003).
    """
    first, others = _turned(weighted, aim, apart)
    none = first[:, 0] == 0.0
    pivot, at_zero = np.where(none, 1.0, first[:, 0]), none
    for _ in range(TURNS):
        rows = np.concatenate([others, first[at_zero, 1:]])
        common = nnls(rows[:, :-1], rows[:, -1])[0] if rows.shape[1] > 1 else np.zeros(0)
        own = np.where(none, 0.0, (first[:, -1] - first[:, 1:-1] @ common) / pivot)
        before, at_zero = at_zero, none | (own < 0.0)
        if np.array_equal(at_zero, before):
            return np.concatenate([np.maximum(own, 0.0), common])
    return nnls(weighted.T, aim)[0]


def _turned(weighted: Array, aim: Array, apart: Index) -> tuple[Array, Array]:
    """The lines of each residual in triangular rows of its own column, the common ones and the aim: the first row of
    each, (n, c + 2), and all others, without the own columns, which are zero there, (rows, c + 1)."""
    n = len(apart)
    every = np.vstack([weighted[:n].sum(axis=0), weighted[n:], aim])  # of a residual's lines, the first is its own
    parts = np.moveaxis(np.pad(every, ((0, 0), (0, 1)))[:, apart], 0, -1)
    turned = np.asarray(np.linalg.qr(parts, mode="r"))
    return turned[:, 0], turned[:, 1:, 1:].reshape(-1, turned.shape[-1] - 1)
