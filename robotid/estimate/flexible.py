"""The second step: initial values of what flexes, from frequency responses (section 6.2 of the paper)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.display import Displayed
from robotid.estimate.among_axes import response_among_axes
from robotid.estimate.average_stiffness import SpringLaw, equivalent_law, published_law, simulate_twist
from robotid.estimate.flexible_start import rigid_inertia, starts
from robotid.estimate.linear_response import FLOOR, ResponseFit, fit_response, linear_part, total_inertia
from robotid.estimate.notch import Reading, read_off
from robotid.estimate.responses import Response, ResponseOptions, responses
from robotid.estimate.result import Estimate
from robotid.estimate.rigid import RigidResult
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.port import Port
from robotid.model.term import Motion, Role, Term
from robotid.signals.frf import Frf
from robotid.signals.record import Record

LARGEST_DOUBT = 0.2  # relative standard deviation at which a response does not tell a parameter
PLAIN = ResponseOptions()
LARGEST_FACTOR = 2.0  # between the rigid inertias of a response and of step 1, unless the latter is less certain
CONTRADICTION = 3.0  # standard deviations of step 1's rigid inertia
HOPELESS = 3.0  # relative standard deviation at which an estimate is no start


@dataclass(frozen=True, slots=True, eq=False)
class FlexReading:
    """What one response tells.

    notch, resonance, gain : as read off; Jm = 1 / gain; k = notch^2 Ja with step 1's rigid inertia, as in the paper.
    notch, resonance and k are None where there is none. values, relative_std : the parametric fit of eq. (13), by
    dotted name. misfit : its weighted rms residual, about 1 where a linear joint explains the response. twist : the
    largest, of a linear spring.
    """

    record: str
    notch: float | None = field(metadata={"unit": "rad/s", "positive": True})
    resonance: float | None = field(metadata={"unit": "rad/s", "positive": True})
    gain: float = field(metadata={"unit": "rad/s2/Nm", "finite": True})
    Jm: float = field(metadata={"unit": "kg m2", "finite": True})
    k: float | None = field(metadata={"unit": "Nm/rad"})
    values: dict[str, float] = field(metadata={"unit": "SI", "finite": True})
    relative_std: dict[str, float] = field(metadata={"unbounded": True, "least": 0.0})
    misfit: float = field(metadata={"least": 0.0})
    twist: float = field(metadata={"unit": "rad", "least": 0.0})


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FlexResult(Displayed):
    """Step 2. frfs, readings : one a record, or one for all realisations of an excitation. parameters : means over the
    responses that tell the stiffness. springs : the nonlinear law by eq. (14) and, where several responses tell it, by
    equivalent linearisation. guesses : by dotted name of the model; where no response tells the stiffness, those of a
    joint that flexes above what was excited; empty for one that cannot flex."""

    frfs: tuple[Frf, ...]
    readings: tuple[FlexReading, ...]
    parameters: tuple[Estimate, ...]
    springs: tuple[SpringLaw, ...]
    guesses: dict[str, float] = field(metadata={"unit": "SI", "finite": True})
    remarks: tuple[str, ...]

    @property
    def left_out(self) -> tuple[dict[str, float], ...]:
        """What each response asks for, by dotted name, where none of them tells the stiffness for certain."""
        if self.parameters:
            return ()
        return tuple({name: one.values[name] for name in self.guesses if name in one.values} for one in self.readings)


@dataclass(frozen=True, slots=True)
class TwoMasses:
    """The parameters of eq. (13) by dotted name: inertias of motor and arm, stiffness and (if any) damping between."""

    motor: str
    arm: str
    stiffness: str
    damping: str | None

    @classmethod
    def of(cls, linear: Joint) -> TwoMasses | None:
        """Those of a linear joint, None where it lacks a mass or the spring."""
        roles = ((Role.MASS, Port.MOTOR), (Role.MASS, Port.ARM), (Role.SPRING, Port.GEAR))
        found = [_first(linear, role, port) for role, port in roles]
        motor, arm, stiffness = found
        if motor is None or arm is None or stiffness is None:
            return None
        return cls(motor, arm, stiffness, _first(linear, Role.DAMPER, Port.GEAR))


def _first(joint: Joint, role: Role, port: Port, *, linear: bool = True) -> str | None:
    """Of the effects with a role at a port, the first one's inertia, stiffness or damping."""
    found = (n for n, place in joint.playing(role).items() if place.port is port and place.term.linear is linear)
    return next(found, None)


@dataclass(frozen=True, slots=True, eq=False)
class _Fitted:
    """A response with its reading and its parametric fit; rigid : inertia [kg m2] that the fit gives all masses moving
    together, total : that of step 1 and its standard deviation; twists : (n,) a record of it [rad]."""

    response: Response
    reading: Reading
    fit: ResponseFit
    rigid: float
    total: tuple[float, float]
    twists: tuple[Array, ...]
    parts: TwoMasses

    @property
    def contradicts(self) -> bool:
        """Whether the fit has another rigid inertia than step 1: where dry friction holds a joint for long, its
        response is that of a joint as heavy as that."""
        total, std = self.total
        return bool(abs(np.log(self.rigid / total)) > max(np.log(LARGEST_FACTOR), CONTRADICTION * std / total))

    @property
    def tells(self) -> bool:
        """Whether inertias and stiffness are certain and not those of another joint, and the notch where the response
        can have seen it."""
        if self.contradicts:
            return False
        omega, values, parts = self.response.frf.omega, self.fit.values, self.parts
        notch = np.sqrt(values[parts.stiffness] / values[parts.arm])
        needed = (parts.motor, parts.stiffness, parts.arm)
        certain = all(self.fit.relative_std.get(name, 0.0) < LARGEST_DOUBT for name in needed)
        # Notch and resonance between two lines are the error of one line.
        apart = notch * (np.sqrt(self.rigid / values[parts.motor]) - 1) > np.median(np.diff(omega))
        return bool(certain and apart and 0.5 * omega[0] < notch < 2 * omega[-1])


def fit_flexible(
    joint: Joint,
    parameters: Parameters,
    rigid: RigidResult,
    records: Sequence[Record],
    options: ResponseOptions = PLAIN,
) -> FlexResult:
    """Initial values of inertias, springs and dampers.

    parameters : step 1's values in them; those that are not free keep theirs. options : of the responses.
    A joint that cannot flex, or records that do not show it, give an empty result with a remark.
    Raises NumericsError where step 1 found no inertia or a record is not excited.
    """
    linear = linear_part(joint)
    parts = TwoMasses.of(linear)
    if joint.masses == 1 or parts is None:
        lacking = "the model lacks the inertia of motor or arm, or a linear spring between them"
        why = "a rigid axis has no flexibility" if joint.masses == 1 else lacking
        return FlexResult((), (), (), (), {}, (why,))
    if not records:
        return FlexResult((), (), (), (), {}, ("no record serves the flexible initialisation",))
    values = parameters.by_name
    free = {name for name, is_free in zip(parameters.names, parameters.free, strict=True) if is_free}
    # Friction is step 1's to find: it hardly shows in a response.
    rubs = {name for place in linear.placed if place.term.friction for name in linear.names[place.at]}
    fixed = {name: values[name] for name in linear.names if name not in free or name in rubs}
    total = rigid_inertia(linear, {name: values[name] for name in linear.names}, rigid)
    found = _responses(joint, parameters, records, options)
    fitted = [_fit(linear, parts, values, fixed, total, response) for response in found]
    result = _result(linear, joint, parameters, total[0], fitted)
    if not result.guesses:
        result = _stiff(result, linear, values, fixed, total[0], fitted)
    if not any(place.term.companion for place in joint.placed):
        return result
    return _without_pose(result, joint, parts.arm, _inertia_of_poses(joint, parameters, records))


def _stiff(
    result: FlexResult,
    linear: Joint,
    values: Mapping[str, float],
    fixed: Mapping[str, float],
    total: float,
    fitted: Sequence[_Fitted],
) -> FlexResult:
    """The result with the start of a joint that flexes just above what was excited, where no response tells how:
    masses of half of the rigid inertia each, and a spring between them with its notch at the highest line."""
    top = max(float(f.response.frf.omega[-1]) for f in fitted)
    reading = replace(fitted[0].reading, notch=top, gain=2.0 / total)
    found = starts(linear, values, reading, total, fitted[0].response.frf.omega)[0]
    guesses = {name: value for name, value in found.items() if name not in fixed}
    values_found = ", ".join(f"{name} = {value:.3g}" for name, value in guesses.items())
    remark = f"no response tells the stiffness; a start that flexes just above what was excited: {values_found}"
    return replace(result, guesses=guesses, remarks=(*result.remarks, remark))


def _inertia_of_poses(joint: Joint, parameters: Parameters, records: Sequence[Record]) -> Array:
    """What effects that read a companion add to the inertia of the arm, (n,) samples of all records [kg m2]."""
    resting = linear_part(joint)
    known = parameters.by_name
    none, theta = np.zeros((resting.nx, 1)), np.array([known[name] for name in resting.names])
    own = resting.slopes(none, none[: resting.masses], none[0], theta)[1][1, 1, 0]
    added = []
    for record in records:
        along, still = joint.along(record), np.zeros((joint.nx, len(record)))
        s = along.directions(still, still[: joint.masses], record.t, parameters.values)
        mass = along.slopes(still, s, record.t, parameters.values)[1][1, 1] - own
        added.append(np.broadcast_to(mass, len(record)))
    return np.concatenate(added)


def _without_pose(result: FlexResult, joint: Joint, arm: str, added: Array) -> FlexResult:
    """The inertia of the arm (its name) without what its poses added to it in the responses, (n,). Where no mass would
    be left, step 1 did not tell inertia, pose and coupling apart: what reads a companion starts absent."""
    if arm not in result.guesses:
        return result
    mean = float(added.mean())
    if result.guesses[arm] - mean + min(0.0, float(added.min())) > 0.0:
        guesses = result.guesses | {arm: result.guesses[arm] - mean}
        estimates = tuple(replace(e, value=e.value - mean) if e.name == arm else e for e in result.parameters)
        return replace(result, guesses=guesses, parameters=estimates)
    absent: dict[str, float] = {}
    for place in joint.placed:
        if place.term.companion:
            pairs = zip(joint.names[place.at], place.term.parameters, strict=True)
            absent |= {name: p.null for name, p in pairs if p.null is not None}
    remark = f"slow motion does not tell inertia and pose apart: {', '.join(absent)} start absent"
    return replace(result, guesses=result.guesses | absent, remarks=(*result.remarks, remark))


def _responses(
    joint: Joint, parameters: Parameters, records: Sequence[Record], options: ResponseOptions
) -> tuple[Response, ...]:
    """Those of all records, experiments with several axes together as one."""
    named = {record.name: record for record in records}
    groups = [[named[name] for name in group if name in named] for group in options.experiments]
    together = {record.name for group in groups for record in group}
    apart = [record for record in records if record.name not in together]
    found = responses(joint, parameters, apart, options.band, options.window)
    return (response_among_axes(joint, parameters, groups, options.band), *found) if groups else found


def _fit(
    linear: Joint,
    parts: TwoMasses,
    values: Mapping[str, float],
    fixed: Mapping[str, float],
    total: tuple[float, float],
    response: Response,
) -> _Fitted:
    reading = read_off(response.frf)
    begin = starts(linear, values, reading, total[0], response.frf.omega)
    fit = fit_response(linear, response.frf, fixed, begin, total)
    far = (total[0] - fit.values[parts.motor]) / linear.ratio**2
    k, d = fit.values[parts.stiffness], fit.values[parts.damping] if parts.damping else 0.0
    twists = tuple(
        simulate_twist(r.dphi_m, r.sampling_time, linear.ratio, k, d, max(far, fit.values[parts.arm]))
        for r in response.records
    )
    return _Fitted(response, reading, fit, total_inertia(linear, fit.values), total, twists, parts)


def _result(linear: Joint, joint: Joint, parameters: Parameters, total: float, fitted: Sequence[_Fitted]) -> FlexResult:
    telling = [f for f in fitted if f.tells]
    estimates = _means(parameters, telling)
    guesses = {e.name: e.value for e in estimates if e.std < HOPELESS * e.value}
    remarks = _remarks(linear, fitted)
    springs: tuple[SpringLaw, ...] = ()
    nonlinear = _first(joint, Role.SPRING, Port.GEAR, linear=False)
    if nonlinear is not None and telling:
        springs = _spring_laws(telling, guesses, joint.playing(Role.SPRING)[nonlinear].term)
        law, stiffness = springs[-1], telling[0].parts.stiffness
        guesses |= {stiffness: law.k1, nonlinear: law.k3} if law.stiffens else {nonlinear: 0.0}
        remarks += [_law_in_words(law, stiffness, nonlinear, parameters)]
    return FlexResult(
        frfs=tuple(f.response.frf for f in fitted),
        readings=tuple(_as_read(linear, total, f) for f in fitted),
        parameters=estimates,
        springs=springs,
        guesses=guesses,
        remarks=tuple(remarks),
    )


def _means(parameters: Parameters, fitted: Sequence[_Fitted]) -> tuple[Estimate, ...]:
    """Weighted means of the logarithms. std : by the responses' errors; std_robust : at least their scatter."""
    estimates = []
    for name in fitted[0].fit.relative_std if fitted else ():
        logarithms = np.log([f.fit.values[name] for f in fitted])
        weights = 1 / (np.array([f.fit.relative_std[name] for f in fitted]) ** 2 + FLOOR**2)
        mean = float(weights @ logarithms / weights.sum())
        std = 1 / np.sqrt(weights.sum())
        scatter = np.sqrt(weights @ (logarithms - mean) ** 2 / weights.sum() / max(1, len(fitted) - 1))
        value, k = float(np.exp(mean)), parameters.names.index(name)
        lower, upper = float(parameters.lower[k]), float(parameters.upper[k])
        estimates.append(
            Estimate(
                name, value, parameters.units[k], value * float(std), value * float(max(std, scatter)), lower, upper
            )
        )
    return tuple(estimates)


def _spring_laws(fitted: Sequence[_Fitted], means: Mapping[str, float], nonlinear: Term) -> tuple[SpringLaw, ...]:
    """Both laws of k_i = (k1 / Ja)_i Ja, by the notch of each fit and one arm inertia for all; the last one counts.

    nonlinear : the spring whose torque, per unit of its stiffness, is the shape of the law's other part.
    """
    parts = fitted[0].parts
    arm = means.get(parts.arm, fitted[0].fit.values[parts.arm])
    k = np.array([f.fit.values[parts.stiffness] / f.fit.values[parts.arm] * arm for f in fitted])
    k_std = k * np.hypot([f.fit.relative_std.get(parts.stiffness, 0.0) for f in fitted], FLOOR)
    twists = [np.concatenate(f.twists) for f in fitted]
    shapes = [_torque_per_stiffness(nonlinear, x) for x in twists]
    published = published_law(twists, shapes, k, k_std)
    return (published, equivalent_law(twists, shapes, k, k_std)) if len(fitted) > 1 else (published,)


def _torque_per_stiffness(spring: Term, twist: Array) -> Array:
    """Derivative of a spring's torque to its first parameter, with any other at its guess. twist (n,) -> (n,)."""
    zero = np.zeros(len(twist))
    motion = Motion(twist, zero, zero, zero, zero, np.zeros((0, len(twist))))
    return np.asarray(spring.partials(motion, [p.guess for p in spring.parameters]).theta[0])


def _law_in_words(law: SpringLaw, stiffness: str, nonlinear: str, parameters: Parameters) -> str:
    k1, k3 = (name.rpartition(".")[2] for name in (stiffness, nonlinear))
    value = f"{law.k3:.3g} +- {law.k3_std:.2g} {parameters.units[parameters.names.index(nonlinear)]}"
    if law.stiffens:
        return f"stiffness rises with amplitude: {k3} = {value}"
    return f"the amplitudes do not separate {k1} from {k3} ({value}): {k3} starts at zero"


def _as_read(linear: Joint, total: float, fitted: _Fitted) -> FlexReading:
    reading, Jm = fitted.reading, 1 / fitted.reading.gain
    return FlexReading(
        record=fitted.response.frf.record,
        notch=reading.notch,
        resonance=reading.resonance,
        gain=reading.gain,
        Jm=Jm,
        k=None if reading.notch is None else reading.notch**2 * (total - Jm) / linear.ratio**2,
        values=fitted.fit.values,
        relative_std=fitted.fit.relative_std,
        misfit=fitted.fit.misfit,
        twist=float(max(np.abs(x).max() for x in fitted.twists)),
    )


def _remarks(linear: Joint, fitted: Sequence[_Fitted]) -> list[str]:
    beyond = {n for p in linear.placed if p.port in (Port.LINK, Port.TOOL) for n in linear.names[p.at]}
    remarks: list[str] = []
    for f in fitted:
        name = f.response.frf.record
        remarks += [f"{name}: {remark}" for remark in f.response.frf.remarks]
        if f.reading.notch is None:
            remarks.append(f"{name}: the response shows no notch")
        if f.contradicts:
            found = f"a rigid inertia of {f.rigid:.3g} kg m2, slow motion one of {f.total[0]:.3g}"
            remarks.append(f"{name}: the response asks for {found}, and is left out")
        elif not f.tells:
            remarks.append(f"{name}: the response does not tell the stiffness and is left out")
        unseen = [n for n, std in f.fit.relative_std.items() if n in beyond and std > LARGEST_DOUBT]
        if unseen:
            remarks.append(f"{name}: no second resonance that tells {', '.join(unseen)}")
    return remarks
