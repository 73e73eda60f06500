"""What one section must know of another: effects, ports, parameters and records that are named must exist."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import inf

from robotid.body.results import INERTIA, TORQUE
from robotid.catalogue import EFFECTS
from robotid.channels import CHANNELS
from robotid.config.excitation import ExperimentSettings
from robotid.config.robot import Effects, structure_of
from robotid.config.schema import Config
from robotid.config.suggest import suggest
from robotid.config.tree import Step
from robotid.model.companion import CompanionKind, companion_of, drive_of
from robotid.model.parameters import Parameter
from robotid.model.port import Port, Signal
from robotid.model.structure import RECORD_CHANGE, Structure, changed
from robotid.model.term import Role
from robotid.signals.plausibility.procedure import CHECKS
from robotid.terms import TERMS

PLACES = [*map(str, Port), *map(str, Signal)]
BODY_SIGNALS = {INERTIA: CompanionKind.INERTIA, TORQUE: CompanionKind.TORQUE}
"""What the body adds to the records."""
FLEXIBLE = (Port.GEAR, Port.LINK, Port.TOOL)


@dataclass(frozen=True, slots=True)
class Problem:
    """Something to correct. loc : keys and indices that lead to it."""

    loc: tuple[Step, ...]
    what: str
    hint: str = ""


def problems(config: Config) -> Iterator[Problem]:
    """Everything that does not fit together, the most basic first."""
    robot, plant = config.robot, config.plant
    yield from _effects(robot.model, robot.gear_ratio, ("robot", "model"))
    yield from _companions(config)
    yield from _coupled(config)
    yield from _body(config)
    yield from _changes(config)
    yield from _parameters(config)
    if plant is not None:
        if plant.model is not None:
            yield from _effects(plant.model, robot.gear_ratio, ("plant", "model"))
        yield from _truth(plant.parameters, config.plant_structure(), ("plant", "parameters"))
    yield from _records(config)
    yield from _accepted(config)
    yield from _experiments(config)
    yield from _fit(config)
    yield from _thresholds(config)
    yield from _diagnosis(config)


def _accepted(config: Config) -> Iterator[Problem]:
    for k, name in enumerate(config.check.accept):
        if name not in CHECKS:
            yield Problem(("check", "accept", k), f'there is no check "{name}"', suggest(name, CHECKS, many=20))


def declared(structure: Structure) -> dict[str, Parameter]:
    """What the effects of a structure declare, by dotted name; effects that do not exist are passed over."""
    found = {}
    for effect in (*structure.terms, *structure.channels):
        name = companion_of(effect.partition(".")[2])[0]
        kind = TERMS.get(name) or CHANNELS.get(name)
        found.update({f"{effect}.{p.symbol}": p for p in (kind.parameters if kind else ())})
    for effect in structure.changes:
        if (name := changed(effect)[1]) in found:
            found[effect] = replace(found[name], guess=0.0, bounds=(-inf, inf), null=0.0, grid=())
    return found


def _effects(model: Effects, gear_ratio: float | None, at: tuple[Step, ...]) -> Iterator[Problem]:
    for place, effects in model.items():
        if place not in PLACES:
            yield Problem((*at, place), f'there is no port or signal "{place}"', suggest(place, PLACES))
            continue
        for i, effect in enumerate(effects):
            loc = (*at, place, i)
            yield from _placed(place, effect, loc)
            if effect in effects[:i]:
                yield Problem(loc, f"{effect} is listed twice", "an effect acts once at a port")
    yield from _masses(model, gear_ratio, at)


def _placed(place: str, effect: str, loc: tuple[Step, ...]) -> Iterator[Problem]:
    """Whether an effect exists and may act where it is listed."""
    effect = companion_of(effect)[0]
    if effect not in TERMS and effect not in CHANNELS:
        known: Mapping[str, object] = CHANNELS if place in list(Signal) else TERMS
        hint = suggest(effect, known, many=0) or suggest(effect, EFFECTS, many=0)
        yield Problem(loc, f'there is no effect "{effect}"', hint or "`robotid explain` lists them all")
        return
    allowed = [str(p) for p in (TERMS[effect].ports if effect in TERMS else CHANNELS[effect].signals)]
    if place not in allowed:
        yield Problem(loc, f"{effect} does not act at {place}", f"list it under {' or '.join(allowed)}")


def _companions(config: Config) -> Iterator[Problem]:
    """Whether every effect that reads a companion names one that all records have, and no other effect does."""
    for place, effects in config.robot.model.items():
        for i, effect in enumerate(effects):
            yield from _companion(config, effect, ("robot", "model", place, i))
    plant = config.plant
    for place, effects in (plant.model or {}).items() if plant else ():
        for i, effect in enumerate(effects):
            if _reads_companion(effect):
                yield Problem(("plant", "model", place, i), f"{effect} reads a companion, which no excitation moves")
    if plant is not None and plant.model is None and plant.body is not None:
        for place, effects in config.robot.model.items():
            for i, effect in enumerate(effects):
                if _reads_companion(effect):
                    what = f"the virtual robot cannot have {effect}: plant.body is what couples its axes"
                    yield Problem(("robot", "model", place, i), what, "list its own effects under plant.model")


def _reads_companion(effect: str) -> bool:
    kind = EFFECTS.get(companion_of(effect)[0])
    return kind is not None and kind.companion is not None


def _coupled(config: Config) -> Iterator[Problem]:
    """Whether all axes of a virtual robot move together, in every record."""
    body = config.plant.body if config.plant else None
    if body is not None:
        for name, one in body.others.items():
            loc = ("plant", "body", "others", name)
            yield from _effects(one.model, one.gear_ratio, (*loc, "model"))
            yield from _truth(one.parameters, structure_of(one.model, one.gear_ratio, False), (*loc, "parameters"))
    for k, record in enumerate(config.records):
        if record.excite is None:
            continue
        at, axes = ("records", k), () if body is None else body.axes
        if body is None and (record.pose or record.others):
            what = "nothing couples this joint with other axes"
            yield Problem((*at, "pose" if record.pose else "others"), what, "add plant.body to a robot with robot.axes")
        if body is not None and set(record.others) != set(body.others):
            yield Problem((*at, "others"), f"others must be {', '.join(body.others)}, the other axes of plant.body")
        for name in record.pose if body is not None else ():
            if name not in axes:
                yield Problem((*at, "pose", name), f'there is no axis "{name}"', suggest(name, axes))
        yield from _together(record.excite, record.others, at)


def _together(
    own: ExperimentSettings, others: Mapping[str, ExperimentSettings], at: tuple[Step, ...]
) -> Iterator[Problem]:
    """Whether the axes of a record move as long, at the same samples, as often."""
    for name, other in others.items():
        loc, hint = (*at, "others", name), "give all axes of a record the same"
        if other.sampling_time != own.sampling_time:
            what = f"sampling times of {other.sampling_time:g} and {own.sampling_time:g} s in one record"
            yield Problem((*loc, "sampling_time"), what, hint)
        elif other.samples != own.samples:
            length, mine = (one.samples * one.sampling_time for one in (other, own))
            yield Problem(
                loc, f"axis {name} moves for {length:g} s where another does for {mine:g} s", f"{hint} duration"
            )
        elif other.realisations != own.realisations:
            yield Problem((*loc, "realisations"), "axes of one record with other numbers of realisations", hint)
    if any(block.orthogonal for block in (own, *others.values())):
        yield from _orthogonal(own, others, at)


def _orthogonal(
    own: ExperimentSettings, others: Mapping[str, ExperimentSettings], at: tuple[Step, ...]
) -> Iterator[Problem]:
    """Whether the multisines of all axes of a record can be orthogonal."""
    axes, here = len(others) + 1, (*at, "excite")
    if not others:
        yield Problem((*here, "orthogonal"), "one axis by itself is orthogonal to none", "leave orthogonal out")
    elif own.realisations % axes:
        hint = f"give realisations: {axes}, or a multiple"
        yield Problem(here, f"orthogonal multisines of {axes} axes take as many experiments", hint)
    for name, other in others.items():
        if not other.orthogonal or other.excited_lines != own.excited_lines:
            what = f"axis {name} is not excited at the same frequencies"
            yield Problem(
                (*at, "others", name), what, "give orthogonal multisines of all axes the same period and band"
            )


def _body(config: Config) -> Iterator[Problem]:
    """Whether every record has the signals of all axes, and none of the body's own."""
    body = config.robot.body
    if body is None:
        return
    wanted = {one.angle: "angle" for one in body.axes.values() if one.angle}
    wanted |= {one.torque: "drive" for one in body.axes.values() if one.torque}
    for k, record in enumerate(config.records):
        kinds = record.kinds
        if record.excite is not None and not record.others:
            yield Problem(("records", k), f"{record.name} is of one axis alone", "a body needs records of all axes")
            return
        for name in BODY_SIGNALS:
            if name in record.signals:
                yield Problem(("records", k, "signals", name), f"{name} is what robot.body adds", "rename the signal")
        for name, kind in wanted.items():
            if name not in kinds:
                yield Problem(("records", k), f"{record.name} has no signal {name}", f"add {name} of kind {kind}")
            elif kinds[name] != kind:
                what = f"{name} is of kind {kinds[name]}, not {kind}"
                yield Problem(("records", k, "signals", name), what, f"write kind: {kind}")


def _companion(config: Config, effect: str, loc: tuple[Step, ...]) -> Iterator[Problem]:
    """Whether an effect reads a companion where it must, one that is there and of its kind."""
    name, companion = companion_of(effect)
    kind = EFFECTS.get(name)
    if kind is None:
        return
    if kind.companion is None:
        if companion:
            yield Problem(loc, f"{name} reads no companion", f"write {name}")
        return
    if config.robot.body is not None and BODY_SIGNALS.get(companion) == kind.companion:
        return
    known = list(dict.fromkeys(key for r in config.records for key, one in r.kinds.items() if one == kind.companion))
    known += [key for key, one in BODY_SIGNALS.items() if config.robot.body is not None and one == kind.companion]
    hint = f"write {name}[{known[0]}]" if known else f"add one of kind {kind.companion} to signals of the records"
    if not companion:
        yield Problem(loc, f"{name} reads a companion of kind {kind.companion}", hint)
    elif companion not in known:
        yield Problem(loc, f'no record has a signal "{companion}" of kind {kind.companion}', hint)
    else:
        lacking = [r.name for r in config.records if companion not in r.kinds]
        if lacking:
            yield Problem(loc, f"{', '.join(lacking)} has no signal {companion}", f"add {companion} to its signals")


def _masses(model: Effects, gear_ratio: float | None, at: tuple[Step, ...]) -> Iterator[Problem]:
    """Whether every mass has inertia and the gear a ratio."""
    beyond = [port for port in Port if port is not Port.MOTOR and model.get(port)]
    flexible = [port for port in FLEXIBLE if model.get(port)]
    if gear_ratio is None and beyond:
        yield Problem(
            (*at, beyond[0]), "effects beyond the motor need robot.gear_ratio", "add gear_ratio: phi_a / phi_m"
        )
    needed = [Port.MOTOR] + [Port.ARM] * bool(flexible) + [Port.TOOL] * bool(model.get(Port.TOOL))
    for port in needed:
        if not _plays(Role.MASS, model.get(port, ())):
            loc = at if port not in model else (*at, port)
            yield Problem(loc, f"the {port} has no inertia", f"add {_players(Role.MASS, port)} to {port}")
    if flexible and not _plays(Role.SPRING, model.get(Port.GEAR, ())):
        hint = f"add {_players(Role.SPRING, Port.GEAR)} to gear"
        yield Problem(at, "nothing carries torque from the motor to the arm", hint)
    if model.get(Port.TOOL) and not _plays(Role.SPRING, model.get(Port.LINK, ())):
        hint = f"add {_players(Role.SPRING, Port.LINK)} to link"
        yield Problem(at, "nothing carries torque from the arm to the tool", hint)


def _plays(role: Role, effects: Iterable[str]) -> bool:
    """Whether a linear mass or spring is among the effects: a cubic spring alone carries nothing at small twist, and a
    mass with a motion of its own does not move with its port."""
    found = [TERMS[effect] for effect in effects if effect in TERMS]
    return any(term.linear and term.role is role and not term.states for term in found)


def _players(role: Role, port: Port) -> str:
    """The effects that play a role at a port, as a hint names them."""
    return " or ".join(name for name, term in TERMS.items() if port in term.ports and _plays(role, (name,)))


def _changes(config: Config) -> Iterator[Problem]:
    """Whether the records and the parameters that differ in them exist."""
    for record, names in config.robot.changes.items():
        loc = ("robot", "changes", record)
        yield from _known_record(config, record, loc)
        for i, name in enumerate(names):
            yield from _known_parameter(config, name, (*loc, i))
            if name in names[:i]:
                yield Problem((*loc, i), f"{name} is listed twice", "a parameter differs once in a record")


def _known_record(config: Config, record: str, loc: tuple[Step, ...]) -> Iterator[Problem]:
    records = [name for r in config.records for name in r.names]
    if record not in records:
        yield Problem(loc, f'there is no record "{record}"', suggest(record, records))


def _known_parameter(config: Config, name: str, loc: tuple[Step, ...]) -> Iterator[Problem]:
    known = declared(replace(config.structure(), changes=()))
    if name not in known:
        yield Problem(loc, f'the model has no parameter "{name}"', suggest(name, known))


def _parameters(config: Config) -> Iterator[Problem]:
    known = declared(config.structure())
    for name, settings in config.robot.parameters.items():
        loc = ("robot", "parameters", name)
        if name not in known:
            yield Problem(loc, f'the model has no parameter "{name}"', suggest(name, known))
        elif settings.guess is not None:
            bounds = settings.bounds or known[name].bounds
            yield from _within(settings.guess, bounds, known[name].unit, (*loc, "guess"), "the guess")
    for i, name in enumerate(config.fit.fix):
        if name not in known:
            yield Problem(("fit", "fix", i), f'the model has no parameter "{name}"', suggest(name, known))


def _truth(parameters: Mapping[str, float], structure: Structure, at: tuple[Step, ...]) -> Iterator[Problem]:
    known = declared(structure)
    for name, value in parameters.items():
        loc = (*at, name)
        if name not in known:
            yield Problem(loc, f'the virtual robot has no parameter "{name}"', suggest(name, known))
        else:
            yield from _within(value, known[name].bounds, known[name].unit, loc, "the truth")
    for name in (name for name in known if name not in parameters):
        yield Problem(at, f'"{name}" is missing', "the virtual robot needs every parameter of its model")


def _within(
    value: float, bounds: tuple[float, float], unit: str, loc: tuple[Step, ...], what: str
) -> Iterator[Problem]:
    lower, upper = bounds
    if not lower <= value <= upper:
        yield Problem(loc, f"{what} {value:g} lies outside the bounds {lower:g} to {upper:g} {unit}".rstrip())


def _records(config: Config) -> Iterator[Problem]:
    names = [r.name for r in config.records]
    for i, record in enumerate(config.records):
        if record.name in names[:i]:
            yield Problem(("records", i, "name"), f'two records have the name "{record.name}"')
        if record.excite is not None and config.plant is None:
            yield Problem(
                ("records", i, "excite"), "there is no robot to excite", "add a plant section, or give a file instead"
            )
    if not any(r.role == "estimate" for r in config.records):
        yield Problem(("records",), "no record has the role estimate", "at least one is needed to fit a model to")


def _experiments(config: Config) -> Iterator[Problem]:
    """Whether the experiments that are to tell axes apart are there, and hold all axes."""
    records = {name: record for record in config.records for name in record.names}
    for i, group in enumerate(config.init_flex.experiments or ()):
        loc = ("init_flex", "experiments", i)
        for k, name in enumerate(group):
            if name not in records:
                yield Problem((*loc, k), f'there is no record "{name}"', suggest(name, records))
                return
            if records[name].role != "estimate" or records[name].use == "rigid":
                yield Problem((*loc, k), f"{name} serves no initialisation of what flexes", "give it use: flex")
        kinds = [records[name].kinds for name in group]
        shown = [{n for n, kind in one.items() if kind == "angle" and one.get(drive_of(n)) == "drive"} for one in kinds]
        if any(len(group) != len(names) + 1 for names in shown):
            others = ", ".join(sorted(set().union(*shown))) or "no other axis"
            what = f"{len(group)} experiments, whose records show angle and torque of {others}"
            yield Problem(loc, what, "give as many experiments as axes, all with the signals of all axes")


def _fit(config: Config) -> Iterator[Problem]:
    roles = {name: record.role for record in config.records for name in record.names}
    models = config.fit.models or {"m1": config.names("estimate")}
    for model, records in models.items():
        loc = ("fit", "models", model)
        if not records:
            yield Problem(loc, "a model needs at least one record")
        for i, name in enumerate(records):
            if name not in roles:
                yield Problem((*loc, i), f'there is no record "{name}"', suggest(name, roles))
            elif roles[name] == "validate":
                yield Problem((*loc, i), f"{name} has the role validate and is held out of every fit")
            elif name in records[:i]:
                yield Problem((*loc, i), f"{name} is listed twice")
    if config.fit.best is not None and config.fit.best not in models:
        yield Problem(("fit", "best"), f'there is no model "{config.fit.best}"', suggest(config.fit.best, models))
    for name in (name for name in config.fit.weights if name not in roles):
        yield Problem(("fit", "weights", name), f'there is no record "{name}"', suggest(name, roles))


def _thresholds(config: Config) -> Iterator[Problem]:
    names = [name for record in config.records for name in record.names]
    for name in config.validation.thresholds.fit_percent:
        if name not in names:
            loc = ("validate", "thresholds", "fit_percent", name)
            yield Problem(loc, f'there is no record "{name}"', suggest(name, names))


def _diagnosis(config: Config) -> Iterator[Problem]:
    """Whether the model to diagnose, the effects to leave out, and those to extend by exist."""
    models, model = config.fit.models or {"m1": ()}, config.diagnose.model
    if model is not None and model not in models:
        yield Problem(("diagnose", "model"), f'there is no model "{model}"', suggest(model, models))
    known = [*TERMS, *CHANNELS, RECORD_CHANGE]
    for i, effect in enumerate(config.diagnose.skip):
        place, _, name = companion_of(effect)[0].rpartition(".")
        if name not in known:
            yield Problem(("diagnose", "skip", i), f'there is no effect "{name}"', suggest(name, known))
        elif place and place not in PLACES:
            yield Problem(("diagnose", "skip", i), f'there is no port or signal "{place}"', suggest(place, PLACES))
    for i, effect in enumerate(config.extend.effects or ()):
        yield from _addition(config, effect, ("extend", "effects", i))


def _addition(config: Config, effect: str, loc: tuple[Step, ...]) -> Iterator[Problem]:
    """Whether the model can be extended by an effect, written as port.effect or as a change."""
    place, dot, name = effect.partition(".")
    if place == RECORD_CHANGE:
        record, parameter = changed(effect)
        yield from _known_record(config, record, loc)
        yield from _known_parameter(config, parameter, loc)
    elif not dot:
        yield Problem(loc, f'"{effect}" has no port', "write it as port.effect, such as motor.stribeck")
    elif place not in PLACES:
        yield Problem(loc, f'there is no port or signal "{place}"', suggest(place, PLACES))
    elif effect in config.structure().effects:
        yield Problem(loc, f"{effect} is in the model already")
    else:
        yield from _placed(place, name, loc)
        yield from _companion(config, name, loc)
