"""Stage excite: the references that the records of the virtual robot ask for, within the limits of the joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.catalogue import assemble
from robotid.config.excitation import ExperimentSettings, MultisinePart, SquarePart, TrianglePart
from robotid.config.records import RecordSettings
from robotid.config.schema import Config
from robotid.errors import ConfigError
from robotid.estimate.regressor import moving
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.term import Motion
from robotid.signals.differentiate import Kinematics
from robotid.signals.limits import Limits, Torque, check_limits
from robotid.signals.multisine import judged_crest_factor, low_crest_phases, multisine, random_phases
from robotid.signals.orthogonal import advanced
from robotid.signals.reference import Excitation, Reference
from robotid.signals.waves import square, triangle

ROUNDING = 1e-4  # by which the crest factor may exceed what was asked for


@dataclass(frozen=True, slots=True, eq=False)
class Wave:
    """One part of a reference. values (realisations, n); lines [Hz] (k,); crest_factors, one a realisation."""

    values: Array
    lines: Array
    crest_factors: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Place:
    """Which axis a reference is for, counted from 0 from the base on, of those that move together."""

    number: int = 0
    axes: int = 1


class References:
    """References by record and axis, each made once for all axes of a robot."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, str], tuple[Reference, ...]] = {}

    def of(self, record: RecordSettings, axis: str, block: ExperimentSettings, place: Place) -> tuple[Reference, ...]:
        """What an axis follows in a record."""
        if (record.name, axis) not in self._made:
            self._made[record.name, axis] = realise(record.names, block, place)
        return self._made[record.name, axis]


def excite(settings: Config, shared: References | None = None) -> Excitation:
    """Every record's references. A block of several realisations gives set2, set2_r2, set2_r3. shared : by the axes of
    a robot.

    Raises ConfigError where a limit or a crest factor cannot be kept, or the controller cannot follow.
    """
    known, body = shared or References(), settings.plant.body if settings.plant else None
    places = {name: Place(k, len(body.axes)) for k, name in enumerate(body.axes)} if body is not None else {}
    own = body.axis if body is not None else ""
    references: list[Reference] = []
    others: dict[str, list[Reference]] = {name: [] for name in places if name != own}
    for record in settings.records:
        if record.excite is not None:
            _require_controller(settings, record.name, record.excite.quantity)
            made = known.of(record, own, record.excite, places.get(own, Place()))
            torque = None if record.excite.limits.torque is None else _torque(settings, record.name)
            for reference in made:
                limits = Limits(**record.excite.limits.model_dump())
                check_limits(reference, limits, torque, sliding=settings.robot.linear)
            references += made
            for name, block in record.others.items():
                others[name] += known.of(record, name, block, places[name])
    _distinct([record.name for record in settings.records], references)
    return Excitation(tuple(references), {name: tuple(found) for name, found in others.items()})


def realise(names: Sequence[str], block: ExperimentSettings, place: Place | None = None) -> tuple[Reference, ...]:
    """The references of one excite block. names : one a realisation, the first that of the block; place : of the axis,
    by default the only one."""
    waves = [_wave(names[0], part, block, place or Place()) for part in block.parts]
    lines = np.unique(np.concatenate([wave.lines for wave in waves]))
    period = block.common_period
    return tuple(
        Reference(
            name=name,
            sampling_time=block.sampling_time,
            ref=np.sum([wave.values[r] for wave in waves], axis=0),
            kind=block.quantity,
            period=period * block.sampling_time if period <= block.samples else None,
            band=(float(lines[0]), float(lines[-1])) if len(lines) else None,
            lines=lines,
            crest_factor=max((wave.crest_factors[r] for wave in waves if wave.crest_factors), default=None),
            block=names[0],
            realisation=r + 1,
        )
        for r, name in enumerate(names)
    )


def _wave(name: str, part: TrianglePart | SquarePart | MultisinePart, block: ExperimentSettings, place: Place) -> Wave:
    period, n = block.in_samples(part.period), block.samples
    if isinstance(part, MultisinePart):
        return _multisine(name, part, block, place)
    if isinstance(part, SquarePart):
        once = square(part.amplitude, period, n, part.rise / block.sampling_time)
    else:
        once = triangle(part.amplitude, period, n)
    return Wave(np.broadcast_to(once, (block.realisations, n)), np.zeros(0))


def _multisine(name: str, part: MultisinePart, block: ExperimentSettings, place: Place) -> Wave:
    """All realisations have the same amplitudes, so that their responses may be averaged. The phases of every axis are
    its own; orthogonal ones are drawn anew after as many realisations as there are axes, and advance in between."""
    samples = block.in_samples(part.period)
    lines = np.array(part.lines)
    amplitudes = np.interp(lines / part.period, *np.array(part.table).T)
    lines, amplitudes = lines[amplitudes > 0], amplitudes[amplitudes > 0]
    if not len(lines):
        raise ConfigError("the spectrum is zero on every line", where=name, hint="lengthen the period")
    rows, crests, phases = [], [], np.zeros(0)
    experiments = place.axes if block.orthogonal else 1
    for r in range(block.realisations):
        drawn, experiment = divmod(r, experiments)
        if not experiment:
            rng = np.random.default_rng([part.seed, drawn, place.number])
            if part.crest_factor is None:
                phases = random_phases(len(lines), rng)
            else:
                phases = low_crest_phases(lines, amplitudes, samples, part.crest_factor, rng)
        played = advanced(phases, place.number, place.axes, experiment)
        crests.append(judged_crest_factor(lines, amplitudes, played, samples))
        rows.append(multisine(lines, amplitudes, played, samples))
    if part.crest_factor is not None:
        _require_crest(name, max(crests[::experiments]), part.crest_factor)
    periods = np.array(rows)
    if part.peak is not None:
        periods *= part.peak / np.abs(periods).max()
    repeated = periods[:, np.arange(block.samples) % samples]
    return Wave(repeated, lines / part.period, tuple(crests))


def _require_crest(name: str, reached: float, target: float) -> None:
    if reached > target + ROUNDING:
        raise ConfigError(
            f"no phases were found for a crest factor of {target:.4g}, only for {reached:.4g}",
            where=name,
            hint=f"ask for crest_factor: {np.ceil(100 * reached) / 100:g}, or null for random phases",
        )


def _require_controller(settings: Config, name: str, quantity: str) -> None:
    if settings.plant is not None and settings.plant.controller.kind != quantity:
        follows = settings.plant.controller.kind
        what = f"the excitation prescribes a {quantity}, but the controller of the plant follows a {follows}"
        raise ConfigError(what, where=name, hint=f"give the excitation quantity: {follows}, or another controller")


def _torque(settings: Config, name: str) -> Torque:
    """Torque of the rigid joint with the parameters that the configuration guesses."""
    joint = assemble(settings.structure())
    guesses = {key: known.guess for key, known in settings.robot.parameters.items() if known.guess is not None}
    needed = [key for place, _ in moving(joint) for key in joint.names[place.at]]
    missing = [key for key in needed if key not in guesses]
    if missing:
        what = f"a limit of torque needs a guess of {', '.join(missing)}"
        raise ConfigError(what, where=name, hint="give it under robot.parameters")
    theta = np.array([guesses.get(key, 0.0) for key in joint.names])
    return lambda motion: _rigid_torque(joint, theta, motion)


def _rigid_torque(joint: Joint, theta: Array, motion: Kinematics) -> Array:
    """Motor torque that moves the joint rigidly, (n,)."""
    torque, at_rest = np.zeros(len(motion.speed)), np.zeros((0, len(motion.speed)))
    for place, factor in moving(joint):
        x, v, a = factor * motion.position, factor * motion.speed, factor * motion.acceleration
        here = Motion(x, v, a, np.sign(v), np.zeros(len(v)), at_rest)
        torque += factor * place.term.torque(here, theta[place.at].tolist())
    return torque


def _distinct(records: Sequence[str], references: Sequence[Reference]) -> None:
    for reference in references:
        if reference.realisation > 1 and reference.name in records:
            hint = f"rename that record: it is what realisation {reference.realisation} of {reference.block} is called"
            raise ConfigError("two references have this name", where=reference.name, hint=hint)
