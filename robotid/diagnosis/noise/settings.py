"""Tuning constants of the noise room."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class NoiseSettings:
    """How noise is distinguished from a misfit, and what noise a diagnosis reckons with."""

    max_fisher_steps: int = 20  # of a fit of levels to a spectrum; two levels settle within these or swing for ever
    settled_change: float = 1e-6  # of the largest level, relative: far below what any record can show
    band_surprise: float = 4.0  # standard deviations of a band's mean that pass for chance, over some ten bands
    torque_evidence: float = 10.0  # gain of -2 log-likelihood that proves a torque noise beside a misfit (p = 0.002)
    torque_hint: float = 4.0  # the same where there is no misfit: noise that is overlooked is taken for an effect
    record_parts: int = 8  # of a record, so that some of them have no reversal
    min_band_lines: int = 32  # frequencies: the mean of a narrower band is too uncertain to bound a level
    hidden_share: float = 0.1  # of the quietest band: the least output noise beside a torque noise that hides it
    clip: float = 3.0  # robust standard deviations: of a normal noise a two-hundredth of the energy lies beyond
    tolerance: float = 1.5  # of the noise in an octave, which may exceed it: no noise is quite as white or red as that
    draws: int = 8  # of a noise through a simulation: an octave's mean to a third of its chance
    encoder_turns: int = 8  # fractions of a quantum: of a sawtooth, all harmonics below the eighth then count alike
    encoder_band: float = (
        0.1  # relative width over which an encoder's spectrum is averaged: a quarter of the octaves' chance
    )
    failed_windows: int = 10  # in 4000 samples of such a simulation: with more it is not worth its time
    rest_share: float = 0.25  # of the typical output noise: a record that shows less was at rest
    unexplained_energy: float = 2.0  # over that of noise: beyond it, something is left that nothing known explains
    linear_share: float = 0.02  # of the misfit: as close as linear columns come to a large one
    max_linear_energy: float = 20.0  # over that of noise: more than that is not excused by linear columns
    variance_resolution: float = 0.1  # of the logarithm of the torque's variance: a twentieth of its deviation
    min_variance_ratio: float = 1e-12  # of the largest torque variance: where the search for it begins


NOISE = NoiseSettings()
