"""The equations of motion as the body of a function of time, states, torque and parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from robotid.export.equations.code import Language, Writer, used_names
from robotid.export.equations.node import Node, Untraceable, is_number, make, named
from robotid.export.equations.trace import ACTING, Equations, direction, edge, parameter, state, trace
from robotid.export.handover.handed_model import HandedModel
from robotid.model.port import Signal

SLOW = "slow{}"  # name of the smoothing speed of a coordinate in the formulae


@dataclass(frozen=True, slots=True)
class FunctionBody:
    """Statements that define force0, force1, ..., and what is made of them.

    mass : formulae of the mass matrix, by row; diagonal : whether only its diagonal counts. rates : of the states, of
    the accelerations a0, a1, ...; first_state : of `angle` and `speed`. parameters : those that the formulae read.
    smoothing : speed of each coordinate below which dry friction is smooth.
    """

    states: tuple[str, ...]
    parameters: Mapping[str, float]
    smoothing: tuple[float, ...]
    lines: tuple[str, ...]
    mass: tuple[tuple[str, ...], ...]
    diagonal: bool
    rates: tuple[str, ...]
    first_state: tuple[str, ...]

    @property
    def mass_diagonal(self) -> tuple[str, ...]:
        """The diagonal of the mass matrix."""
        return tuple(row[j] for j, row in enumerate(self.mass))


def cannot_be_written(model: HandedModel) -> dict[str, str]:
    """Effects of a model that are no formula of the present motion, and why."""
    found = dict[str, str]()
    joint = model.joint
    for signal, channel in joint.channels:
        name = f"{signal}.{channel.name}"
        if signal is not Signal.TORQUE:
            found[name] = "it belongs to the sensor, not to the motion"
        elif (why := _obstacle(model, name)) is not None:
            found[name] = why
    for place in joint.placed:
        name = place.effect
        if place.term.companion_name:
            found[name] = f"it reads {place.term.companion_name}, which is recorded"
    rest = model.without(found)
    for place in rest.joint.placed:
        name = place.effect
        if _fails(rest) is None:
            break
        if (why := _obstacle(model, name)) is not None:
            found[name] = why
            rest = rest.without({name: why})
    return found


def _obstacle(model: HandedModel, effect: str) -> str | None:
    """Why an effect has no formula, None where it has one: tried beside what makes a joint of it."""
    others = [e for e in model.fit.structure.channels if e != effect]
    alone = model.without(dict.fromkeys(others, "")) if effect in model.fit.structure.channels else model
    without = alone.without({effect: ""})
    why = _fails(alone)
    return why if why is not None and _fails(without) != why else None


def _fails(model: HandedModel) -> str | None:
    try:
        trace(model.joint, model.theta)
    except Untraceable as error:
        return str(error)
    return None


@dataclass(frozen=True, slots=True)
class Spelling:
    """How a language reads a parameter by its dotted name, a state by its number, and the smoothing speed of a
    coordinate."""

    parameter: Callable[[str], str]
    state: Callable[[int], str]
    slow: Callable[[int], str]


def function_body(model: HandedModel, language: Language, spelling: Spelling) -> FunctionBody:
    """The equations of a model, all of whose effects have formulae."""
    joint, theta = model.joint, model.theta
    equations = trace(joint, theta)
    names = {parameter(k): spelling.parameter(name) for k, name in enumerate(equations.parameters)}
    names |= {state(k): spelling.state(k) for k in range(joint.nx)}
    names |= {SLOW.format(j): spelling.slow(j) for j in range(joint.masses)}
    rates = (*equations.positions, *equations.memory)
    masses = {(i, j): one for i, row in enumerate(equations.mass) for j, one in enumerate(row)}
    diagonal = all(is_number(one, 0.0) for (i, j), one in masses.items() if i != j)
    results = [(f"force{j}", one) for j, one in enumerate(equations.force)]
    results += [(f"rate{k}", one) for k, one in enumerate(rates)]
    results += [(f"mass{i}{j}", one) for (i, j), one in masses.items() if i == j or not diagonal]
    edges = [(edge(k), make("sign", equations.edges[k])) for k in _in_order(equations)]
    read = set(used_names([one for _, one in (*results, *edges)]))
    directions = [(direction(j), _smooth_direction(equations, j)) for j in range(joint.masses) if direction(j) in read]
    writer = Writer(language, names)
    lines = writer.statements([(ACTING, equations.acting), *directions])
    for one in edges:
        lines += writer.statements([one])
    lines += writer.statements(results)
    flow = len(equations.positions)
    return FunctionBody(
        states=equations.states,
        parameters={name: float(theta[k]) for k, name in enumerate(equations.parameters) if parameter(k) in read},
        smoothing=tuple(model.slow_speed * (1.0 if j == 0 else abs(joint.ratio)) for j in range(joint.masses)),
        lines=tuple(lines),
        mass=tuple(tuple(f"mass{i}{j}" for j in range(joint.masses)) for i in range(joint.masses)),
        diagonal=diagonal,
        rates=(
            *(f"rate{k}" for k in range(flow)),
            *(f"a{j}" for j in range(joint.masses)),
            *(f"rate{k}" for k in range(flow, len(rates))),
        ),
        first_state=tuple(_first(name, joint.ratio) for name in equations.states),
    )


def _smooth_direction(equations: Equations, j: int) -> Node:
    return make("tanh", make("divide", named(state(equations.speeds.start + j)), named(SLOW.format(j))))


def _in_order(equations: Equations) -> list[int]:
    """Edges, each behind those whose sides its distance reads. Raises Untraceable where they read each other."""
    left, done = list(range(len(equations.edges))), list[int]()
    reads = [{k for k in left if edge(k) in set(used_names([one]))} for one in equations.edges]
    while left:
        free = [k for k in left if not reads[k] - set(done)]
        if not free:
            raise Untraceable("its edges depend on each other")
        done += free
        left = [k for k in left if k not in free]
    return done


def _first(name: str, ratio: float) -> str:
    return {"phi_m": "angle", "dphi_m": "speed", "dphi_a": f"{ratio!r} * speed", "dphi_b": f"{ratio!r} * speed"}.get(
        name, "0.0"
    )
