"""How much of the torque at its port each effect carries, along simulated motions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.model.array import Array, blocks
from robotid.model.port import Port
from robotid.model.port_motion import Placed
from robotid.model.term import Motion
from robotid.model.units import on_axis
from robotid.numerals import plain
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


@dataclass(frozen=True, slots=True, eq=False)
class _Acting:
    """A term at its place along a stretch of samples: the motion of its port, and its torque (n,)."""

    place: Placed
    motion: Motion
    torque: Array


@dataclass(frozen=True, slots=True)
class _Tally:
    """Sums of one effect over all samples so far. square : of its torque; peak : its largest torque, there : where, in
    words, and largest : its share of all torques there."""

    square: float = 0.0
    peak: float = 0.0
    largest: float = 0.0
    there: str = ""

    def with_stretch(self, acting: _Acting, total: Array, trajectory: Trajectory, record: str) -> _Tally:
        """With a stretch of samples. total : absolute torques of all effects at the port, (n,)."""
        torque = acting.torque
        square, k = self.square + float(torque @ torque), int(np.argmax(np.abs(torque)))
        peak = float(abs(torque[k]))
        if peak <= self.peak:
            return replace(self, square=square)
        return _Tally(square, peak, peak / float(total[k]), f"{_motion_at(acting, k, trajectory)} on {record}")


def torque_shares(runs: Iterable[tuple[str, Trajectory]]) -> dict[str, TorqueShare]:
    """Shares of every term that absorbs a torque itself, by dotted name, over (record name, trajectory) pairs of one
    joint. What transforms the motion, as a backlash does, has none."""
    tallies: dict[str, _Tally] = {}
    totals: dict[Port, float] = {}
    places: list[Placed] = []
    for record, trajectory in runs:
        places = [place for place in trajectory.joint.placed if place.transform is None]
        for stretch in _stretches(trajectory, places):
            for port in {place.port for place in places}:
                here = [one for one in stretch if one.place.port is port]
                total = np.sum([np.abs(one.torque) for one in here], axis=0)
                totals[port] = totals.get(port, 0.0) + float(total @ total)
                for one in here:
                    name = one.place.effect
                    tallies[name] = tallies.get(name, _Tally()).with_stretch(one, total, trajectory, record)
    return {place.effect: _share(place, tallies[place.effect], totals[place.port], places) for place in places}


def _share(place: Placed, tally: _Tally, total: float, places: Sequence[Placed]) -> TorqueShare:
    rms = np.sqrt(tally.square / total) if total > 0 else 0.0
    alone = sum(other.port is place.port for other in places) == 1
    return TorqueShare(place.effect, str(place.port), float(rms), tally.largest, tally.there, alone)


def _motion_at(acting: _Acting, k: int, trajectory: Trajectory) -> str:
    """The motion that the effect reads, at sample k."""
    place, m = acting.place, acting.motion
    units = on_axis(linear=trajectory.joint.structure.linear)
    d = place.term.partials(m, trajectory.theta[place.at].tolist())
    if not (isinstance(d.x, float) and d.x == 0.0):
        return f"a {POSITION.get(place.port, 'position')} of {_number(m.x, k)} {units('rad')}"
    if place.reads_acceleration:
        return f"an acceleration of {_number(m.a, k)} {units('rad/s2')}"
    return f"a speed of {_number(m.v, k)} {units('rad/s')}"


def _number(signal: Array, k: int) -> str:
    return plain(abs(float(signal[k if signal.size > 1 else 0])))


def _stretches(trajectory: Trajectory, places: Sequence[Placed]) -> Iterator[list[_Acting]]:
    """The terms at these places, stretch by stretch of samples."""
    joint, theta = trajectory.joint, trajectory.theta
    for at in blocks(len(trajectory.u), BLOCK):
        inputs, x = trajectory.step_inputs(at), trajectory.x[:, at]
        mode = friction_mode(inputs, x)
        ddq = joint.evaluate(x, inputs.u, mode.s, inputs.t, theta, mode.sticking).f[joint.speeds]
        motions = joint.motions(x, ddq, mode.s, inputs.t, theta)
        yield [
            _Acting(place, m, np.broadcast_to(place.term.torque(m, theta[place.at].tolist()), x.shape[1:]))
            for place, m in zip(joint.placed, motions, strict=True)
            if place in places
        ]
