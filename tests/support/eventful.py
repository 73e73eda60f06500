"""Records of the small axis in which something happens once: the torque of an event that nobody recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.events.applied import event_torque
from robotid.diagnosis.events.detection import FoundEvent, find_event
from robotid.diagnosis.events.pieces import scan_pieces
from robotid.diagnosis.results import Event
from robotid.diagnosis.scoring.scan import Scan
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.signals.record import Record
from support.small_bench import STRIBECK, fitted, records

PUSH = Event("slow", "bump", False, 1.7, 2.5, 0.05, 0.0, 0.0)
LEANED = Event("slow", "bump", False, 1.4, 2.6, 0.08, 0.0, 0.0, gradual=True)
KNOCK = Event("wide", "bump", False, 1.0, 1.02, 0.3, 0.0, 0.0)
STEP = Event("slow", "step", True, 2.2, 4.0, 0.1, 0.0, 0.0)
DRIFT = Event("slow", "drift", False, 0.0, 4.0, 0.05, 0.0, 0.0)
LACKING: Mapping[str, Mapping[str, float]] = {"nothing": {}, "stribeck": STRIBECK}
LEVEL = 1e-3


def with_event(record: Record, event: Event | None) -> Record:
    """The record of the same motion, of which the event carried a part."""
    if event is None or event.record != record.name:
        return record
    return replace(record, tau_m=record.tau_m - event_torque(event, record))


@cache
def eventful(event: Event | None, lacking: str = "nothing") -> tuple[Record, ...]:
    """The records of the small bench with an event, and something that the model lacks besides."""
    return tuple(with_event(record, event) for record in records(LACKING[lacking]))


@cache
def scanned(event: Event | None, lacking: str = "nothing") -> tuple[Scan, ...]:
    """The fitted records of these in pieces, with the columns of all candidates."""
    made = eventful(event, lacking)
    model = fitted_model(fitted(list(made)))
    evidence = Evidence(model, [simulate_record(model, r) for r in made if r.name in model.records], [])
    state = first_state(evidence, Criteria(skip=("record_change",)))
    return scan_pieces(model, state.first, state.data.fitted, state.scan.candidates)


@cache
def found(event: Event | None, lacking: str = "nothing") -> FoundEvent | None:
    """The largest event in them."""
    return find_event(scanned(event, lacking), LEVEL)
