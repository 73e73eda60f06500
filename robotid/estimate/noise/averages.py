"""Noise levels, averaged over what a residual leaves open.

Short records hardly tell the memory of the torque's noise, nor its level from that of the output, and an interval is as
long as both are. A mean over what explains the residual is fairer than the likeliest alone (Hoeting et al. 1999).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.estimate.noise.levels import KINSHIP, PRECISION, SCORING, TIE, Choice, choices, whitened
from robotid.estimate.noise.lines import Innovations, Residual, band_edges, band_means
from robotid.estimate.noise.settings import SETTINGS, SMALLEST, LevelSettings
from robotid.estimate.noise.whitening import NoiseLevels
from robotid.model.array import Array


def likely_levels(
    residuals: Sequence[Residual],
    levels: Sequence[NoiseLevels],
    seen: Sequence[Innovations] | None = None,
    settings: LevelSettings = SETTINGS,
) -> list[tuple[float, tuple[NoiseLevels, ...]]]:
    """Levels that explain residuals about as well as the likeliest, with the share of belief in each.

    Among red noises a corner weighs with its likelihood, and beforehand with the root of what the spectra would tell of
    it (Jeffreys 1946): slow ones, which all look alike, count no more often than they can be distinguished. Between
    these noises, a white one and none the criterion of Bayes decides. levels : the likeliest; seen : residuals whitened
    by them.
    """
    if not any(one.signal.any() for one in residuals):
        return [(1.0, tuple(levels))]
    fine = replace(settings, corner_step=settings.fine_step)
    found = choices(residuals, whitened(residuals, levels, settings) if seen is None else seen, fine)
    weights = _beliefs(found)
    least_first = np.argsort(weights)
    left_out = least_first[np.cumsum(weights[least_first]) < settings.left_out]
    weights[left_out] = 0.0
    weights /= weights.sum()
    return [(float(weight), one.levels) for weight, one in zip(weights, found, strict=True) if weight > 0.0]


def _beliefs(found: Sequence[Choice]) -> Array:
    """Shares (k,) that add to one, those of red noises by a sum over evenly spaced logarithms of corners."""
    criteria = np.array([one.criterion for one in found])
    weights = np.exp(-0.5 * (criteria - criteria.min()))
    of_red = np.array([one.at_end is not None for one in found])
    within = weights * np.array([one.shape * (0.5 if one.at_end else 1.0) for one in found])
    if within[of_red].any():  # no corner shows where red noise is not seen at all
        weights[of_red] = weights[of_red].max() * within[of_red] / within[of_red].sum()
    return np.asarray(weights / weights.sum())


def expected_levels(
    residuals: Sequence[Residual],
    levels: Sequence[NoiseLevels],
    seen: Sequence[Innovations] | None = None,
    settings: LevelSettings = SETTINGS,
) -> tuple[NoiseLevels, ...]:
    """The levels with the torque's noise as large as it is on average over what the residuals leave open.

    Short records tell the torque's noise from that of the output poorly, and the likeliest level is then often none,
    which would make an interval far too small. The mean is over the likelihood, the standard deviation of the noise
    beforehand as likely at any value (Gelman 2006). seen : residuals whitened by about these levels.
    """
    silent = levels[0].torque + levels[0].red == 0.0
    shape = replace(levels[0], torque=1.0) if silent else levels[0]
    by = whitened(residuals, levels, settings) if seen is None else seen
    parts = [_shares(one, own, shape, settings) for one, own in zip(residuals, by, strict=True)]
    scales = _scales(parts, shape, silent=silent, settings=settings)
    most = min(one.most_torque for one in residuals) / max(shape.torque, SMALLEST)
    scales = scales[scales <= most] if np.any(scales <= most) else np.array([most])
    costs = np.sum([_output_beside(part, scales)[1] for part in parts], axis=0)
    # Evenly spaced in the logarithm, a standard deviation that is likely at any value weighs with its own size.
    weights = np.sqrt(scales) * np.exp(-0.5 * (costs - costs.min()))
    mean = float(weights @ scales / weights.sum()) if weights.any() else 0.0  # a constant torque has no noise
    outputs = [float(_output_beside(part, np.array([mean]))[0][0]) for part in parts]
    return tuple(
        replace(shape, output=max(output, one.least), torque=mean * shape.torque, red=mean * shape.red)
        for output, one in zip(outputs, residuals, strict=True)
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Shares:
    """Whitened periodogram (f,), and what the output's noise of unit variance and the torque's as it is assumed would
    add to it, (f,) each; count : (f,) how many neighbouring frequencies each is the mean of."""

    power: Array
    output: Array
    torque: Array
    count: Array


def _shares(one: Residual, seen: Innovations, shape: NoiseLevels, settings: LevelSettings) -> _Shares:
    white, red = seen.of_the_torque(one, np.array([shape.corner]))
    torque = shape.torque * white + shape.red * red[0]
    edges = band_edges(len(torque), settings)
    power, output, torque = (band_means(one, edges) for one in (seen.power, seen.gain, torque))
    return _Shares(power, output, torque, np.diff(np.append(edges, len(seen.power))).astype(np.float64))


def _scales(parts: Sequence[_Shares], shape: NoiseLevels, *, silent: bool, settings: LevelSettings) -> Array:
    """Factors on the torque's noise that are tried, about one or, where none was found, about what can just be seen."""
    centre, seen = 1.0, [part for part in parts if part.torque.any()]  # a motor that is held shows no torque
    if silent and seen:
        centre = float(np.median([np.mean(part.power) / np.max(part.torque) for part in seen]))
    return np.asarray(centre * np.geomspace(10.0**-settings.reach, 10.0**settings.reach, settings.scales))


def _output_beside(part: _Shares, scales: Array) -> tuple[Array, Array]:
    """The likeliest variance of the output's noise beside so much of the torque's, and minus twice the logarithm of the
    likelihood, by Fisher scoring of one level. scales (k,) -> (k,) each."""
    beside = scales[:, None] * part.torque
    levels = np.full(len(scales), max(float(np.median(part.power / part.output)), SMALLEST))
    for _ in range(SCORING):
        model = levels[:, None] * part.output + beside
        weight = part.count * (part.output / model) ** 2
        after = np.sum(weight * (part.power - beside) / part.output, axis=1) / weight.sum(axis=1)
        after = np.maximum(after, TIE * levels)
        done = bool(np.all(np.abs(after - levels) <= PRECISION * levels))
        levels = after
        if done:
            break
    model = levels[:, None] * part.output + beside
    return levels, 2 / KINSHIP * (np.log(model) + part.power / model) @ part.count
