"""Tuning constants of the search."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RefitChoiceSettings:
    """Which candidates are refitted, and from where."""

    hopeful_share: float = 0.5  # of the best score's energy: candidates below it are not refitted
    rival_share: float = 0.9  # of the best score's energy: below it none rivals a cause that explains nearly all
    complete_share: float = 0.97  # of the misfit: a cause that explains so much explains it
    least_effects: int = 3  # of those that are refitted: what differs between records must not crowd them out
    max_rounds: int = 3  # of candidates, where none of the best can be refitted
    start_ways: tuple[float, ...] = (1.0, 0.5, 0.1)  # of the way to what a score promises, where refits start
    good_start: float = 0.5  # of a model's energy: a start that leaves less is good, and no other is tried
    doubtful_share: float = 0.5  # of the misfit: a periodic effect that promises less is tried from other points, too
    kept_promise: float = 0.8  # of what a score promises: a refit that removes less has lost its way
    other_points: int = 2  # of a grid that are tried where the best is doubtful
    neighbour_distance: float = 0.1  # relative: points of a grid that are closer lead to the same end


@dataclass(frozen=True, slots=True)
class AcceptanceSettings:
    """What counts as the same, as worth nothing, and as unknown."""

    unchanged_share: float = 0.02  # of the residual's energy: a refit that changes less leaves the columns as they are
    noise_renewals: int = 3  # of the torque's noise before causes are sought beside it
    settled_noise: float = 0.8  # of its variance before: renewed to no less, and it has settled
    physical_sigma: float = 2.0  # standard deviations outside its physical range at which a parameter makes no sense
    amplitude_sigma: float = 3.0  # standard deviations from nothing: an effect that is less is not certain to be there
    known_sigma: float = 1.0  # of them in whatever shape: an effect that is less is known less well than to itself
    same_share: float = 0.02  # of the energy explained: causes closer than that are not distinguished
    same_energy: float = 12.0  # noise variances, inflated: as far apart as chance sets two equal models (p = 5e-4)
    max_same_share: float = 0.1  # of the energy explained: causes further apart are distinguished, whatever the noise
    least_share: float = 1e-3  # of the first model's misfit: less is an error of the simulation itself
    least_motion: float = 1e-5  # of the motion's squared size: more is no such error, whatever the misfit was
    worthless_share: float = 0.1  # of what a cause explained: if no more is lost without it, its worth is gone
    firm_factor: float = 5.0  # times that share: a cause that has so much to lose to first order is not tried without
    collinear_cosine: float = 0.999  # at which columns are the same
    unknown_share: float = 0.1  # of the misfit: a curve that explains less of it is no news
    imitation_share: float = 0.7  # of what a free curve explains: causes that do not reach it only imitate something
    complete_share: float = 0.97  # of the misfit: causes that explain so much are the causes, where noise is reached
    clear_share: float = 0.02  # of the misfit, by which several causes must beat a free curve, and one may miss it
    gain_level: float = 0.05  # of significance of a gain on what was not fitted; half of those of no cause are above 0
    gain_blocks: int = 20  # of time, into which what was not fitted is cut: enough for a spread to a sixth of itself
    telling_blocks: float = 3.0  # beyond its amplitudes, that must tell of a cause: fewer cannot give a spread
    constant_parts: int = 4  # of the records, in which the size of a cause is compared
    constant_spread: float = 0.5  # of a cause's size: what varies more from part to part is none
    trusted_causes: int = 2  # that are added before the question is asked whether they only imitate


@dataclass(frozen=True, slots=True)
class ChangeSettings:
    """When a parameter counts as different on a validation record."""

    loud_energy: float = 2.0  # a sample, over that of the fitted records: less asks for no reason
    far_off: float = 2.0  # times the worst of some draws of the noise: none of as many again comes near
    shortest_part: float = 0.125  # of a record: shorter ones neither ask for a change nor test it
    confirmed_share: float = 0.2  # of the misfit on the second part that a change must remove
    apart: float = 3.0  # times as much as any other record asks for: a record that differs more is another
    same_share: float = 0.02  # of the misfit: changes closer than that are not distinguished
    max_iterations: int = 6  # of a fit of one parameter
    most: int = 3  # parameters that differ on a record: inertia and the two of a weight


CHOICE, ACCEPTANCE, CHANGES = RefitChoiceSettings(), AcceptanceSettings(), ChangeSettings()
