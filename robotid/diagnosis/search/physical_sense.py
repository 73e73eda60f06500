"""Whether the parameters of a refitted cause make physical sense, and differ from nothing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2

from robotid.catalogue import EFFECTS
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.scoring.measured_motion import with_angle
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.estimate.uncertainty import deviations_with_shape
from robotid.model.array import Array
from robotid.model.companion import companion_of
from robotid.model.parameters import Parameter
from robotid.model.physical import PortRange
from robotid.model.port import Port
from robotid.model.units import on_axis
from robotid.simulation.friction.mode import friction_mode
from robotid.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from robotid.diagnosis.search.step import Step


def is_not_physical(step: Step, criteria: Criteria) -> str | None:
    """A cause's parameters must make sense on these records, within what is known of them."""
    model = step.after
    for effect in step.added:
        for name, declared in declarations(effect):
            if declared.physical is None:
                continue
            low, high = declared.physical.range(port_range(model, effect))
            value, std = model.parameters[name], deviation(model, name)
            spread = ACCEPTANCE.physical_sigma * std
            certainly = value + spread < low or value - spread > high
            unknown = std > abs(value) and not low <= value <= high  # these records do not tell it, and it is no law
            if certainly or unknown:
                unit = on_axis(linear=model.structure.linear)(declared.unit)
                size = f"{value:.3g}" if unit == "1" else f"{value:.3g} {unit}"
                known = f", known to {std:.2g}" if unknown else ""
                return f"makes no sense: {declared.symbol} = {size}{known}, and {declared.physical.why}"
    return None


def is_uncertain(step: Step, criteria: Criteria) -> str | None:
    """A cause's size must differ from nothing: all its amplitudes together, as a sine and a cosine have a size. In the
    shape that was found at three deviations; and in any shape it must be known better than to itself."""
    model = step.after
    for effect in step.added:
        sizes = [(name, p) for name, p in declarations(effect) if p.null is not None]
        if sizes and _is_uncertain(model, effect):
            symbol = sizes[0][1].symbol
            value, std = model.parameters[sizes[0][0]], deviation(model, sizes[0][0])
            return f"is not certain to be there: {symbol} = {value:.2g}, known to {std:.2g}"
    return None


def least_deviations(parameters: int, level: float) -> float:
    """How many standard deviations the amplitudes of an effect of so many parameters are from nothing, together, for
    it to be named: three, and significant at a level among all its shapes."""
    return max(ACCEPTANCE.amplitude_sigma, float(np.sqrt(chi2.isf(level, parameters))))


def declarations(effect: str) -> Iterator[tuple[str, Parameter]]:
    """The parameters of an effect by dotted name, as they are declared; none of a change of a record."""
    known = EFFECTS.get(companion_of(effect.rpartition(".")[2])[0])
    for p in known.parameters if known is not None else ():
        yield f"{effect}.{p.symbol}", p


def deviation(model: RefittedModel, name: str) -> float:
    """Standard deviation of a parameter, zero where it was not fitted."""
    at = [i for i, k in enumerate(model.columns) if model.parameters.names[k] == name]
    return float(np.sqrt(max(0.0, model.covariance[at[0], at[0]]))) if at else 0.0


def _is_uncertain(model: RefittedModel, effect: str) -> bool:
    """Whether an effect's amplitudes may be nothing; not where none was fitted."""
    fitted = amplitudes(model, effect)
    if not fitted:
        return False
    covariance, apart = model.covariance, np.array(list(fitted.values()))
    shape = [k for k in model.own_columns(effect) if k not in fitted]
    known, certain = deviations_with_shape(apart, covariance, covariance, list(fitted), shape)
    return known < ACCEPTANCE.known_sigma or certain < ACCEPTANCE.amplitude_sigma


def amplitudes(model: RefittedModel, effect: str) -> dict[int, float]:
    """The fitted amplitudes of an effect, less where it vanishes, by their number among the fitted parameters."""
    names = [model.parameters.names[k] for k in model.columns]
    if effect in names:  # a change of a record is its own size
        return {names.index(effect): model.parameters[effect]}
    sizes = [(name, p.null) for name, p in declarations(effect) if p.null is not None and name in names]
    return {names.index(name): model.parameters[name] - null for name, null in sizes}


def port_range(model: RefittedModel, effect: str) -> PortRange:
    """What the fitted records offer an effect of the model at its place."""
    durations: dict[str, float] = {}
    speeds, ways = [0.0], [0.0]
    for one in model.fitted:
        durations[one.record.name] = durations.get(one.record.name, 0.0) + one.record.duration
        x, v = _motion(with_angle(one.trajectory), effect)
        speeds.append(float(np.abs(v).max()))
        ways.append(float(np.ptp(x)))
    return PortRange(max(durations.values(), default=0.0), max(speeds), max(ways))


def _motion(motion: Trajectory, effect: str) -> tuple[Array, Array]:
    """Position and speed that an effect follows, (n,) each: of its own port, or of the motor where it is a channel or
    watches the motor."""
    joint, x = motion.joint, motion.x
    for k, place in enumerate(joint.placed):
        if place.effect == effect and getattr(place.term, "watches", None) is not Port.MOTOR:
            s = friction_mode(motion.step_inputs(slice(0, x.shape[1])), x).s
            m = joint.motions(x, None, s, motion.t, motion.theta)[k]
            return m.x, m.v
    return motion.phi_m, x[joint.motor_speed]
