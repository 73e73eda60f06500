"""Whether events are accounted for, in words beside fits.

A record holds what an event did to the motion. A validation simulates it by the recorded torque alone, and is wrong by
the event as well; an extension gives its models the torque of the event, before and after.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from robotid.diagnosis.results import Event
from robotid.numerals import listed, significant


def noun(events: Sequence[Event]) -> str:
    """ "event", or "events" where there are several."""
    return "event" if len(events) == 1 else "events"


def accounted_for(events: Sequence[Event]) -> str:
    """What stands beside a fit whose simulation is given these events; empty without any."""
    return f"{noun(events)} accounted for" if events else ""


def not_accounted_for(events: Sequence[Event]) -> str:
    """What stands beside a fit whose simulation is not given these events; empty without any."""
    return f"{noun(events)} not accounted for" if events else ""


def described(event: Event, units: Callable[[str], str]) -> str:
    """An event in a few words, such as "a torque of 0.2 Nm from 1.7 to 2.5 s". units : what a turning axis' unit is
    called here."""
    unit = units("Nm")
    size, torque = f"{significant(event.torque, 2)} {unit}", "force" if unit == "N" else "torque"
    what = f"friction that is larger by {size}" if event.friction else f"a {torque} of {size}"
    if event.kind == "bump":
        grows, until = (" that grows", "and fades until") if event.gradual else ("", "to")
        return f"{what}{grows} from {significant(event.start)} {until} {significant(event.end)} s"
    if event.kind == "step":
        return f"{what} from {significant(event.start)} s on"
    return f"{what} at its end, grown from nothing"


def given(events: Mapping[str, Sequence[Event]], units: Callable[[str], str]) -> str:
    """A sentence on events that both models of an extension are given, with a space before it; empty without any.
    events : by record."""
    found = {name: own for name, own in events.items() if own}
    every = [one for own in found.values() for one in own]
    parts = [f"{listed([described(one, units) for one in own])} in {name}" for name, own in found.items()]
    return f" Both simulations account for the {noun(every)}: {listed(parts)}." if parts else ""


def left_in(events: Mapping[str, Sequence[Event]]) -> str:
    """A sentence on events that a simulation knows nothing of, with a space before it; empty without any. events : by
    record."""
    found = {name: own for name, own in events.items() if own}
    every = [one for own in found.values() for one in own]
    verb = "is" if len(every) == 1 else "are"
    return f" The {noun(every)} in {listed(list(found))} {verb} not accounted for." if found else ""
