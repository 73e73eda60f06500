"""The equations of motion of a joint as formulae: the joint is evaluated with names in the place of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotid.export.equations.node import Node, Untraceable, as_node, named
from robotid.export.equations.traced import Traced, traced
from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.joint import Joint
from robotid.model.port import Signal

TIME, TORQUE = "t", "torque"


@dataclass(frozen=True, slots=True, eq=False)
class Equations:
    """M(x) ddq = force, and the rates of all other states.

    states : names, in order; parameters : dotted names. torque : at the motor behind the channels. positions, memory :
    rates of the states before and behind the speeds. speeds : rows of the state. dry : coordinates with dry friction;
    edges : distance from each edge of a formula, on whose sign it depends. The formulae read the names of `state`,
    `parameter`, `direction`, `edge`, TIME, TORQUE, and `ACTING`, the torque behind the channels.
    """

    states: tuple[str, ...]
    parameters: tuple[str, ...]
    speeds: slice
    acting: Node
    positions: tuple[Node, ...]
    mass: tuple[tuple[Node, ...], ...]
    force: tuple[Node, ...]
    memory: tuple[Node, ...]
    dry: tuple[int, ...]
    edges: tuple[Node, ...]


ACTING = "acting"


def state(k: int) -> str:
    """Name of a state in the formulae."""
    return f"x{k}"


def parameter(k: int) -> str:
    """Name of a parameter in the formulae."""
    return f"p{k}"


def direction(j: int) -> str:
    """Name of the direction of motion of a coordinate in the formulae."""
    return f"s{j}"


def edge(k: int) -> str:
    """Name of the side of an edge in the formulae."""
    return f"side{k}"


def trace(joint: Joint, values: Array) -> Equations:
    """The equations of a joint. values (p,) : of its parameters; those of channels become numbers in the formulae.

    Raises Untraceable where one of its effects has no formula.
    """
    if joint.reads_companions:
        raise Untraceable("it reads a further recorded signal")
    x, theta = _names(state, joint.nx)[:, None], _names(parameter, len(joint.names))
    sides = [edge(k) for k in range(joint.edges)]
    s = traced([named(direction(j)) for j in range(joint.masses)] + [named(side) for side in sides])[:, None]
    t, u = traced([named(TIME)]), traced([named(ACTING)])
    force = joint.force(_like(x), _like(u), _like(s), _like(t), _like(theta))
    motions = joint.motions(_like(x), None, _like(s), _like(t), _like(theta))
    memory: list[Any] = []
    mass: list[list[Any]] = [[0.0] * joint.masses for _ in range(joint.masses)]
    for place, m in zip(joint.placed, motions, strict=True):
        p = place.values(_like(theta))
        memory += place.term.rate(m, p)
        if place.reads_acceleration:
            a = as_node(place.term.partials(m, p).a)
            for i, ci in place.q:
                for j, cj in place.q:
                    mass[i][j] = a * (ci * cj) + mass[i][j]
    speeds = [named(state(k)) for k in range(joint.nx)[joint.speeds]]
    edges = joint.distances(_like(x), _like(s), _like(t), _like(theta)) if joint.edges else ()
    return Equations(
        states=joint.state_names,
        parameters=joint.names,
        speeds=joint.speeds,
        acting=_acting(joint, values),
        positions=tuple(as_node(_weighed(row, speeds)) for row in joint.positions.tolist()),
        mass=tuple(tuple(as_node(entry) for entry in row) for row in mass),
        force=tuple(as_node(one) for one in force),
        memory=tuple(as_node(one) for one in memory),
        dry=joint.dry,
        edges=tuple(as_node(one) for one in edges),
    )


def _acting(joint: Joint, values: Array) -> Node:
    """The torque behind the channels, each of which must act on every sample by itself."""
    u = traced([named(TORQUE)])
    for _, channel, p, _ in joint.channels_on(values, Signal.TORQUE):
        if not acts_at_once(channel, p):
            raise Untraceable(f"{channel.name} remembers what the torque was")
        u = traced(channel.apply(_like(u), 1.0, p))
    return as_node(u)


def acts_at_once(channel: Channel, p: Sequence[float]) -> bool:
    """Whether a channel acts on every sample by itself: then it does not matter in which order samples come."""
    signal = np.sin(np.arange(1.0, 1.0 + PROBE) ** 2)
    step = PROBE * signal.std()
    backwards = channel.apply(step * signal[::-1], STEP, p)[::-1]
    return bool(np.allclose(channel.apply(step * signal, STEP, p), backwards, rtol=1e-9))


PROBE, STEP = 16, 1e-3  # samples of the probe, and their distance [s]


def _names(name: Any, count: int) -> Traced:
    return traced([named(name(k)) for k in range(count)]) if count else traced(np.zeros(0))


def _like(values: Any) -> Any:
    """Formulae where the interface has numbers."""
    return values


def _weighed(factors: Sequence[float], nodes: Sequence[Node]) -> Any:
    total: Any = 0.0
    for factor, node in zip(factors, nodes, strict=True):
        total = node * factor + total
    return total
