"""Tuning constants of the scrutiny."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ScrutinySettings:
    """From when on a fit is doubted.

    torque_factor, torque_percent : its torque error exceeds the start's by this factor, and by so much [%].
    inertia_factor : its inertia and the start's differ by this factor. start_factor : a start value that differs by
    it from the regression's is far from there. at_limit : share of what its measurement allows by which a first
    speed is nearer to the limit. poor_fit [%] : a fit below it is tried with a constant torque in any case.
    offset_gain : factor by which a constant torque must lower the variance of every residual. better : share by
    which a second fit must lower the residuals to be kept. astray [%] : a fit below it is off by ten times the
    motion and more, and nothing is added to it. unstable : factors of e by which an error grows over a record, from
    which on a poor fit is tried in pieces; growth : those over such a piece; pieces : of a record, in which a fit
    that contradicts the torque is tried; points : of a record at which the growth is computed, about.
    """

    torque_factor: float = 1.5
    torque_percent: float = 5.0
    inertia_factor: float = 2.0
    start_factor: float = 2.0
    at_limit: float = 1e-3
    poor_fit: float = 90.0
    offset_gain: float = 0.5
    better: float = 0.01
    astray: float = -900.0
    unstable: float = 10.0
    growth: float = 3.0
    pieces: tuple[int, ...] = (16, 32)
    points: int = 2000


SETTINGS = ScrutinySettings()
