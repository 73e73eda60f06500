"""How much of the torque at its port each effect carries, along simulated motions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array, blocks
from robotid.model.joint import Joint
from robotid.model.port import Port
from robotid.model.port_motion import Placed
from robotid.model.term import Motion
from robotid.model.units import on_axis
from robotid.simulation.friction.mode import friction_mode
from robotid.simulation.trajectory import BLOCK, Trajectory

POSITION = {Port.GEAR: "twist", Port.LINK: "link twist"}


@dataclass(frozen=True, slots=True)
class TorqueShare:
    """One effect's part in the sum of absolute torques at its port.

    rms : ratio of the root mean squares; largest : where the effect's torque peaks; there : that motion in words.
    alone : no other effect acts at the port.
    """

    effect: str
    port: str
    rms: float
    largest: float
    there: str
    alone: bool


@dataclass(slots=True)
class _Tally:
    """Running sums of one effect."""

    square: float = 0.0
    peak: float = 0.0
    largest: float = 0.0
    there: str = ""


def torque_shares(runs: Iterable[tuple[str, Trajectory]]) -> dict[str, TorqueShare]:
    """Shares of every term that absorbs a torque itself, by dotted name, over (record name, trajectory) pairs of one
    joint. What bends the motion, as a backlash does, has none."""
    tallies: dict[str, _Tally] = {}
    totals: dict[Port, float] = {}
    places: list[Placed] = []
    for record, trajectory in runs:
        places = [place for place in trajectory.joint.placed if place.transform is None]
        for motions, torques in _blocks(trajectory, places):
            for port in {place.port for place in places}:
                here = [k for k, place in enumerate(places) if place.port is port]
                total = np.sum([np.abs(torques[k]) for k in here], axis=0)
                totals[port] = totals.get(port, 0.0) + float(total @ total)
                for k in here:
                    tally = tallies.setdefault(_name(places[k]), _Tally())
                    _add(tally, places[k], motions[k], torques[k], total, trajectory.joint, trajectory.theta, record)
    return {_name(place): _share(place, tallies[_name(place)], totals[place.port], places) for place in places}


def _share(place: Placed, tally: _Tally, total: float, places: Sequence[Placed]) -> TorqueShare:
    rms = np.sqrt(tally.square / total) if total > 0 else 0.0
    alone = sum(other.port is place.port for other in places) == 1
    return TorqueShare(_name(place), str(place.port), float(rms), tally.largest, tally.there, alone)


def _add(
    tally: _Tally, place: Placed, m: Motion, torque: Array, total: Array, joint: Joint, theta: Array, record: str
) -> None:
    tally.square += float(torque @ torque)
    k = int(np.argmax(np.abs(torque)))
    if abs(torque[k]) > tally.peak:
        tally.peak, tally.largest = float(abs(torque[k])), float(abs(torque[k]) / total[k])
        tally.there = f"{_say(place, m, k, joint, theta)} on {record}"


def _say(place: Placed, m: Motion, k: int, joint: Joint, theta: Array) -> str:
    """The motion that the effect reads, at sample k."""
    units = on_axis(linear=joint.structure.linear)
    d = place.term.partials(m, theta[place.at].tolist())
    if not (isinstance(d.x, float) and d.x == 0.0):
        return f"a {POSITION.get(place.port, 'position')} of {_number(m.x, k)} {units('rad')}"
    if place.reads_acceleration:
        return f"an acceleration of {_number(m.a, k)} {units('rad/s2')}"
    return f"a speed of {_number(m.v, k)} {units('rad/s')}"


def _number(signal: Array, k: int) -> str:
    return f"{abs(float(signal[k if signal.size > 1 else 0])):.3g}"


def _blocks(trajectory: Trajectory, places: Sequence[Placed]) -> Iterator[tuple[list[Motion], list[Array]]]:
    """Motion and torque of the terms at these places, block by block of samples."""
    joint, theta = trajectory.joint, trajectory.theta
    for at in blocks(len(trajectory.u), BLOCK):
        inputs, x = trajectory.step_inputs(at), trajectory.x[:, at]
        mode = friction_mode(inputs, x)
        ddq = joint.evaluate(x, inputs.u, mode.s, inputs.t, theta, mode.sticking).f[joint.speeds]
        pairs = zip(joint.placed, joint.motions(x, ddq, mode.s, inputs.t, theta), strict=True)
        motions = [m for place, m in pairs if place in places]
        yield (
            motions,
            [
                np.broadcast_to(place.term.torque(m, theta[place.at].tolist()), x.shape[1:])
                for place, m in zip(places, motions, strict=True)
            ],
        )


def _name(place: Placed) -> str:
    return f"{place.port}.{place.term.name}"
