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
from robotid.estimate.noise.settings import MEDIAN, SETTINGS, SMALLEST, LevelSettings
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
    where its simulation does, tells of no noise, and has that of the others.
    """
    telling = telling_of(residuals)
    if 0 < len(telling) < len(residuals):
        return of_all(residuals, _fitted((residuals, settings, near), telling))
    levels = _start(residuals, [*map(_finest, residuals)], settings) if near is None else tuple(near)
    if not telling:
        return levels
    found, energy = _swept(residuals, levels, settings)
    if 1.0 / settings.unlikely < energy < settings.unlikely:
        return found
    other, _ = _swept(residuals, _start(residuals, [*map(_all_of_output, residuals)], settings), settings)
    return min(found, other, key=lambda one: _unlikelihood_of_left(residuals, one, settings))


def telling_of(residuals: Sequence[Residual]) -> list[int]:
    """Numbers of the residuals that tell of a noise."""
    return [k for k, one in enumerate(residuals) if one.signal.any()]


def of_all(residuals: Sequence[Residual], levels: Sequence[NoiseLevels]) -> tuple[NoiseLevels, ...]:
    """The levels of all residuals. levels : of those that tell of a noise, at least one."""
    known = dict(zip(telling_of(residuals), levels, strict=True))
    typical = float(np.median([one.output for one in levels]))
    silent = (replace(levels[0], output=max(one.least, typical)) for one in residuals)
    return tuple(known.get(k, one) for k, one in enumerate(silent))


def _swept(
    residuals: Sequence[Residual], levels: tuple[NoiseLevels, ...], settings: LevelSettings
) -> tuple[tuple[NoiseLevels, ...], float]:
    """Levels whitened and fitted again until they stay, and the mean square of the innovations: at the likeliest it is
    1, for a factor on all levels is free."""
    energy = 1.0
    for _ in range(settings.sweeps):
        seen = whitened(residuals, levels, settings)
        after = min(choices(residuals, seen, settings), key=lambda one: one.criterion).levels
        done = all(_alike(a, b, settings.settled) for a, b in zip(levels, after, strict=True))
        samples = [len(one.signal) for one in residuals]
        levels, energy = after, float(np.average([one.energy for one in seen], weights=samples))
        if done:
            break
    return levels, energy


def _unlikelihood_of_left(
    residuals: Sequence[Residual], levels: Sequence[NoiseLevels], settings: LevelSettings
) -> float:
    """Minus twice the logarithm of the likelihood of the innovations, without what has been taken out of them."""
    total = 0.0
    for one, level, seen in zip(residuals, levels, whitened(residuals, levels, settings), strict=True):
        at_once = innovations_filter(one.response, level).at_once
        total += len(one.signal) * (seen.energy - 2.0 * float(np.log(at_once)))
    return total


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


def _finest(one: Residual) -> float:
    """The variance of the output's noise by the finest differences."""
    return max(_least(one), float(np.median(np.diff(one.sensed, 2) ** 2)) / (MEDIAN * 6.0))


def _least(one: Residual) -> float:
    """The least variance of the output's noise that has any say beside the residual."""
    return max(one.least, TIE * float(np.mean(one.sensed**2)) + SMALLEST)


def _all_of_output(one: Residual) -> float:
    """The same where it is all that makes a residual. Of an encoder so coarse that most samples show no difference at
    all, the finest are next to nothing."""
    return max(one.least, float(np.mean(innovations_filter(one.response, NoiseLevels(1.0))(one.signal) ** 2)), SMALLEST)


def _start(residuals: Sequence[Residual], outputs: Sequence[float], settings: LevelSettings) -> tuple[NoiseLevels, ...]:
    """The torque's white noise that makes the innovations likeliest beside outputs of these variances."""
    best, cost = tuple(map(NoiseLevels, outputs)), np.inf
    n = max(len(one.signal) for one in residuals)
    for omega in 2 * np.pi * np.geomspace(1 / n, 0.5, settings.crossings):
        ratios = [o / one.response.squared(np.array([omega]))[0] for o, one in zip(outputs, residuals, strict=True)]
        torque = float(np.median(ratios))
        tried = tuple(NoiseLevels(output, torque) for output in outputs)
        value = sum(map(_unlikelihood, residuals, tried))
        if value < cost:
            best, cost = tried, value
    return best


def _unlikelihood(one: Residual, levels: NoiseLevels) -> float:
    """Minus twice the logarithm of the innovations' likelihood."""
    whiten = innovations_filter(one.response, levels)
    innovations = whiten(one.signal)
    return float(innovations @ innovations) - 2.0 * len(innovations) * float(np.log(whiten.at_once))


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
    own = np.concatenate([one.output for one in lines])
    slopes = np.zeros(red.shape)
    if len(corners) > 1:
        slopes = np.gradient(red, np.log(corners), axis=0, edge_order=2 if len(corners) > 2 else 1)
    least = np.array([*map(_least, residuals)])
    most = np.array([one.most_torque for one in residuals])
    shapes = _Shapes(own, np.zeros((0, len(own))), of, _apart(of, n))
    options: list[tuple[_Shapes, Array, int | None]] = [(shapes, np.zeros(n), None)]
    options += [(replace(shapes, common=np.vstack([white])), most, None)]
    options += [(replace(shapes, common=np.vstack([white, red[i]])), most, i) for i in range(len(corners))]
    answer = []
    for shown, caps, at in options:
        output, common, cost = _bounded(power, shown, count, least, caps)
        torque, reds = np.vstack([common, np.zeros((2 - len(common), n))])
        corner = float(corners[at]) if at is not None else 1.0
        pairs = zip(output.tolist(), torque.tolist(), reds.tolist(), strict=True)
        these = tuple(NoiseLevels(level, white_one, slow, corner) for level, white_one, slow in pairs)
        criterion = cost + (n + len(common)) * float(np.log(count.sum()))
        if at is None:
            answer.append(Choice(criterion, these))
            continue
        shape = _root_information(output, common, shown, reds[of] * slopes[at], count)
        answer.append(Choice(criterion, these, shape, at in (0, len(corners) - 1)))
    return answer


@dataclass(frozen=True, slots=True, eq=False)
class _Shapes:
    """Lines of n residuals one after the other, and what noise of unit variance shows there.

    own (f,) : of the output of the residual that a line belongs to; common (c, f) : of the torque, which all have in
    common; of (f,) : the residual of each line; apart : as of `_apart`.
    """

    own: Array
    common: Array
    of: Index
    apart: Index

    def spectrum(self, output: Array, common: Array) -> Array:
        """The lines (f,) at levels of the outputs (n,) and of the torque (c,) or (c, n)."""
        levels = common[:, self.of] if common.ndim == 2 else common[:, None]
        return np.asarray(output[self.of] * self.own + (levels * self.common).sum(axis=0))


def _bounded(power: Array, shapes: _Shapes, count: Array, least: Array, most: Array) -> tuple[Array, Array, float]:
    """The likeliest level of every noise in every residual, of the outputs (n,) and of the torque (c, n), and minus
    twice the logarithm of its likelihood.

    least : (n,) of the output's noise; most : (n,) of the torque's white one. What is at its bound stays there while
    the others are sought: cut off afterwards, it would have taken what is theirs.
    """
    n, c = len(least), len(shapes.common)
    at_most, bound, free = np.zeros(n, dtype=np.bool_), np.zeros((c, n)), shapes
    while True:
        output, common, cost = _likeliest(power, free, count, shapes.spectrum(least, bound))
        over = ~at_most & (common[0] > most) if c else np.zeros(n, dtype=np.bool_)
        if not over.any():
            break
        at_most |= over
        bound[0, over] = most[over]
        free = replace(free, common=np.where(at_most[shapes.of] & (np.arange(c) == 0)[:, None], 0.0, shapes.common))
    levels = np.repeat(common[:, None], n, axis=1)
    levels[:1, at_most] = most[at_most]
    return least + output, levels, cost


def likeliest_in_common(
    powers: Sequence[Array], own: Sequence[Array], common: Sequence[Array]
) -> tuple[Array, Array, float]:
    """Levels that explain several periodograms (f,) best: of a shape of each one's own (f,), (n,), and of shapes that
    all have in common, (c, f) each, (c,); and minus twice the logarithm of their likelihood. None is negative."""
    of = np.repeat(np.arange(len(powers)), [*map(len, powers)])
    shapes = _Shapes(np.concatenate(own), np.concatenate(common, axis=1), of, _apart(of, len(powers)))
    power = np.concatenate(powers)
    return _likeliest(power, shapes, np.ones(len(power)), np.zeros(len(power)))


def _likeliest(power: Array, shapes: _Shapes, count: Array, fixed: Array) -> tuple[Array, Array, float]:
    """Levels of the outputs (n,) and of the torque (c,), the same in all residuals, none negative, that explain a
    periodogram (f,) best, and minus twice the logarithm of their likelihood.

    count : (f,) how many neighbouring frequencies each line is the mean of; fixed : (f,) what is there besides. Fisher
    scoring, each step a least-squares problem with non-negative unknowns.
    """
    n = len(shapes.apart)
    size = np.maximum(np.bincount(shapes.of, shapes.own, n) / len(power), SMALLEST)
    common_size = np.maximum(shapes.common.mean(axis=1), SMALLEST)
    own, common = shapes.own / size[shapes.of], shapes.common / common_size[:, None]
    scaled = replace(shapes, own=own, common=common)
    model, least = np.full(len(power), power.mean()), 1e-12 * power.mean() + SMALLEST
    before = np.zeros(n + len(common))
    for _ in range(SCORING):
        weights = np.sqrt(count) / model
        levels = _least_squares(own * weights, common * weights, weights * (power - fixed), shapes.apart)
        model = np.maximum(scaled.spectrum(levels[:n], levels[n:]) + fixed, least)
        if np.abs(levels - before).max() <= PRECISION * levels.max():
            break
        before = levels
    cost = 2 / KINSHIP * float(count @ (np.log(model) + power / model))
    return levels[:n] / size, levels[n:] / common_size, cost


def _root_information(output: Array, common: Array, shapes: _Shapes, slope: Array, count: Array) -> float:
    """Root of Fisher's information on what changes a spectrum by a slope (f,), all levels, (n,) and (c, n), free.

    Whittle (1953): of the logarithm of a spectrum every independent line tells one.
    """
    roots = np.sqrt(count / KINSHIP) / np.maximum(shapes.spectrum(output, common), SMALLEST)
    own, parts = shapes.own * roots * (output > 0.0)[shapes.of], common[:, shapes.of] * shapes.common * roots
    length = np.maximum(np.bincount(shapes.of, own**2), SMALLEST)

    def beyond_own(column: Array) -> Array:
        along = np.bincount(shapes.of, own * column) / length
        return np.asarray(column - along[shapes.of] * own)

    left, seen = beyond_own(slope * roots), np.array([beyond_own(part) for part in parts if part.any()])
    if len(seen):
        taken, *_ = lstsq(seen.T, left, lapack_driver="gelsy")  # of gelsd singular values may fail to converge
        left = left - taken @ seen
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


def _apart(of: Index, n: int) -> Index:
    """The lines of each of n residuals, (n, lines of the longest), -1 where there are no more. of : (f,) the residual
    of each line, those of one in a row."""
    count = np.bincount(of, minlength=n)
    numbers = np.arange(count.max())
    return np.where(numbers < count[:, None], (np.cumsum(count) - count)[:, None] + numbers, -1)


def _least_squares(own: Array, common: Array, aim: Array, apart: Index) -> Array:
    """The least squares to an aim (f,), no level (n + c,) negative, of one column for each of n residuals, own (f,) in
    its lines, and of common ones (c, f). apart : as of `_apart`.

    The lines of a residual are turned into as many rows as columns concern them (Golub & Van Loan 2013, section 5.3),
    of which the first alone holds its own column. So the common levels are those of all other rows, and of the first
    ones of residuals whose own level is zero; which these are is found by turns (Hintermueller, Ito & Kunisch 2003).
    """
    if len(apart) == 1:
        return nnls(np.vstack([own, common]).T, aim)[0]
    first, others = _turned(own, common, aim, apart)
    none = first[:, 0] == 0.0
    pivot, at_zero = np.where(none, 1.0, first[:, 0]), none
    for _ in range(TURNS):
        rows = np.concatenate([others, first[at_zero, 1:]])
        shared = nnls(rows[:, :-1], rows[:, -1])[0] if len(common) else np.zeros(0)
        alone = np.where(none, 0.0, (first[:, -1] - first[:, 1:-1] @ shared) / pivot)
        before, at_zero = at_zero, none | (alone < 0.0)
        if np.array_equal(at_zero, before):
            return np.concatenate([np.maximum(alone, 0.0), shared])
    every = np.zeros((len(apart), len(aim)))
    for column, lines in zip(every, apart, strict=True):
        column[lines[lines >= 0]] = own[lines[lines >= 0]]
    return nnls(np.vstack([every, common]).T, aim)[0]


def _turned(own: Array, common: Array, aim: Array, apart: Index) -> tuple[Array, Array]:
    """The lines of each residual in triangular rows of its own column, the common ones and the aim: the first row of
    each, (n, c + 2), and all others, without the own columns, which are zero there, (rows, c + 1)."""
    columns = np.vstack([own, common, aim])
    parts = np.moveaxis(np.pad(columns, ((0, 0), (0, 1)))[:, apart], 0, -1)
    turned = np.asarray(np.linalg.qr(parts, mode="r"))
    return turned[:, 0], turned[:, 1:, 1:].reshape(-1, turned.shape[-1] - 1)
