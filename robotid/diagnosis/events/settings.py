"""Tuning constants of the detection of events."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class EventSettings:
    """How finely events are placed in time, and what they are compared with."""

    bins: int = 48  # of a record, in which an event may begin or end
    fine_bins: int = 16  # into which the two bins about a begin or an end are cut, twice over
    longest_bump: float = 0.4  # of a record: a longer one cannot be compared with the rest of it
    standstill: float = 0.02  # of the largest speed of a record: below it the direction of friction fades
    step_ways: int = 6  # independent steps in the rest of a record, by which one is judged
    drift_ways: int = 5  # half cosines after the first, by which a drift is judged
    hopeful_share: float = 0.5  # of the largest event's energy: those below it are not placed finely
    own_share: float = (
        0.02  # of an event's energy that all effects and changes of records leave: less, and it is theirs
    )
    cut_share: float = 0.1  # of an event's energy that shows where records are cut elsewhere: less, and the cut made it
    least_share: float = 0.5  # of the misfit of all records: with less, most of it happens at other times, too
    leading_share: float = 0.8  # of what the best effect explains: an event that explains more goes before it
    chance: float = 3.0  # standard deviations of the energy of noise: less holds no event
    ripples: int = 24  # of a turn of the motor, up to which a measured torque may ripple: twice six of two pole pairs
    pieces: int = 12  # of a record, simulated afresh: an event soon leads a whole record astray
    max_resizings: int = 3  # of an event, each beside the parameters refitted without it
    max_events: int = 4  # that are set aside: a record with more is no record of a machine at work
    memories: tuple[float, ...] = (0.01, 0.1, 1.0, 10.0)  # of a torque that wanders, over the length of the record
    least_wander: float = 1e-2  # of the noise's variance: the smallest level of it that is tried
    most_wander: float = 1e8  # and the largest
    levels: int = 41  # of it
    wander_draws: int = 200  # of it, which tell what an event gains by chance: the scale of that to a twentieth
    dependent: float = 1e-9  # relative eigenvalue from which a direction of all known columns counts as none
    least_left: float = 1e-4  # of an event's energy that known columns must leave, lest it is one of their effects


EVENTS = EventSettings()
