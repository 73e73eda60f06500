"""Whether a fit that ended well can be believed.

An error of the model goes into the parameters and the first states where these can imitate it: the least squares are
then found, and wrong. Such a fit moves away from what is known without it: the torque of the rigid motion, the inertia
of the start, the measured first speed. It is then tried again with a constant torque free, the commonest thing that a
model lacks and that makes an open simulation drift.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate.cutoff import choose_cutoff
from robotid.estimate.first_states import first_state_limits
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.linear_response import total_inertia
from robotid.estimate.residual import TRIAL_PATIENCE, measured_output, observed
from robotid.estimate.result import End, FitResult
from robotid.estimate.rigid import RigidResult, fit_rigid, torque_error
from robotid.interrupt import INTERRUPTS
from robotid.model.array import Array
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.term import Role
from robotid.model.units import unit_of
from robotid.numerals import plain
from robotid.progress import Iteration
from robotid.signals.differentiate import ParallelFilter
from robotid.signals.metrics import fit_percent
from robotid.signals.record import SHORTEST_PIECE, Quantity, Record
from robotid.simulation.first_guess import measured_guess
from robotid.simulation.simulate import simulate

LEFT_OUT = "what a frequency response asks for was left out of the start; the fit that starts from it simulates better"
FAR_START = "fitted once more from what the initialisation found, far from the start that was given"
WEIGHT = "gravity"
OFFSET, OFFSET_SUFFIX = "motor.constant_torque", "_offset"


@dataclass(frozen=True, slots=True)
class ScrutinySettings:
    """From when on a fit is doubted.

    torque_factor, torque_percent : its torque error exceeds the start's by this factor, and by so much [%].
    inertia_factor : its inertia and the start's differ by this factor. start_factor : a start value that differs by
    it from the regression's is far from there. at_limit : share of what its measurement allows by which a first
    speed is nearer to the limit. poor_fit [%] : a fit below it is tried with a constant torque in any case.
    offset_gain : factor by which a constant torque must lower the variance of every residual. better : share by
    which a second fit must lower the residuals to be kept. astray [%] : a fit below it is off by ten times the
    motion and more, and nothing is added to it. unstable : factors of e by which an error grows over a record, from
    which on a poor fit is tried in pieces; growth : those over such a piece; pieces : of a record, in which a fit
    that contradicts the torque is tried; points : of a record at which the growth is computed, about.
    """

    torque_factor: float = 1.5
    torque_percent: float = 5.0
    inertia_factor: float = 2.0
    start_factor: float = 2.0
    at_limit: float = 1e-3
    poor_fit: float = 90.0
    offset_gain: float = 0.5
    better: float = 0.01
    astray: float = -900.0
    unstable: float = 10.0
    growth: float = 3.0
    pieces: tuple[int, ...] = (16, 32)
    points: int = 2000


SETTINGS = ScrutinySettings()


@dataclass(frozen=True, slots=True, eq=False)
class FitTask:
    """What is fitted: the arguments of `fit_model`. found : what the initialisation found, also of parameters for which
    another start was given. left_out : starts that it found and does not trust."""

    name: str
    joint: Joint
    parameters: Parameters
    records: Sequence[Record]
    options: FitOptions
    log: Callable[[Iteration], None] | None = None
    found: Mapping[str, float] = field(default_factory=dict)
    left_out: tuple[Parameters, ...] = ()

    def fit(self) -> FitResult:
        """The fit of `fit_model`, and its errors."""
        return fit_model(self.name, self.joint, self.parameters, self.records, self.options, self.log)

    def attempt(self) -> FitResult | None:
        """The fit, None where the records cannot be simulated."""
        try:
            return self.fit()
        except NumericsError:
            return None

    def with_options(self, **changes: Any) -> FitTask:
        """The same with other options."""
        return replace(self, options=replace(self.options, **changes))


@dataclass(frozen=True, slots=True, eq=False)
class ScrutinisedFit:
    """A fit, and the one from the same start with a constant torque free, which the model does not have; None where
    that is not far better, or not asked for. The name of the latter is that of the fit and OFFSET_SUFFIX."""

    fit: FitResult
    with_offset: FitResult | None = None


def scrutinised_fit(task: FitTask) -> ScrutinisedFit:
    """The fit of `fit_model`, with `remarks` on what makes it doubtful, and on what a constant torque would change.

    A doubtful fit is tried again from its start with a constant torque free. Where that explains the records far
    better, the declared model is fitted once more from there, and the better of its two fits is kept. Of a task that is
    interrupted after its first fit, this fit is kept.
    """
    if task.options.choose_horizon:
        return _in_chosen_pieces(task)
    hopeless = _hopeless_as_whole(task)
    if hopeless is not None:
        return ScrutinisedFit(hopeless)
    try:
        first, begun = _first_fit(task)
    except NumericsError:
        nearer = _nearer_start(task)
        if nearer is None:
            raise
        return _noted(scrutinised_fit(nearer), FAR_START)
    found = ScrutinisedFit(first)
    if first.end is not End.INTERRUPTED:
        try:
            found = _scrutinised(first, begun.with_options(interruptible=False))
        except INTERRUPTS:
            if not task.options.interruptible:
                raise
            found = ScrutinisedFit(replace(first, end=End.INTERRUPTED))
    return found if begun.parameters is task.parameters else _noted(found, LEFT_OUT)


def _first_fit(task: FitTask) -> tuple[FitResult, FitTask]:
    """The fit from starts that are not trusted where one of them leads to a fit that can be, else the best of what they
    and the start itself lead to; and the task with the start that led there. Where friction holds a joint for long,
    slow motion and response contradict each other, and only a simulation tells which is right.

    Raises NumericsError where the records cannot be simulated from any.
    """
    own = replace(task, left_out=())
    others = [start for start in task.left_out if not np.array_equal(start.values, task.parameters.values)]
    begun = [replace(own, parameters=start, found={}) for start in others]
    fits = list[tuple[FitResult, FitTask]]()
    for one in begun:
        found = one.attempt()
        if found is not None:
            fits.append((found, one))
            if found.end is End.INTERRUPTED or _is_believed(found, one):
                return fits[-1]
    try:
        fits.append((own.fit(), own))
    except NumericsError:
        if not fits:
            raise
    return min(fits, key=lambda one: one[0].misfit)


def _is_believed(fit: FitResult, task: FitTask) -> bool:
    """Whether nothing speaks against a fit, and it simulates all records well."""
    return min(fit.fit_percent.values()) >= SETTINGS.poor_fit and not any(
        doubts(fit, task.joint, task.parameters, task.records)
    )


def _scrutinised(first: FitResult, task: FitTask) -> ScrutinisedFit:
    joint, parameters, records = task.joint, task.parameters, task.records
    found = tuple(doubts(first, joint, parameters, records))
    if not found and min(first.fit_percent.values()) >= SETTINGS.poor_fit:
        return ScrutinisedFit(first)
    nearer = _nearer_start(task)
    again = None if nearer is None else nearer.attempt()
    if nearer is not None and again is not None and again.misfit < (1 - SETTINGS.better) * first.misfit:
        return _noted(_scrutinised(again, nearer), FAR_START)
    if task.options.horizon is None and min(first.fit_percent.values()) < SETTINGS.poor_fit:
        in_pieces = _in_pieces(first, task)
        if in_pieces is not None:
            return ScrutinisedFit(in_pieces)
        beside = _beside_lacking(task)
        if beside is not None:
            return ScrutinisedFit(beside)
    _refuse_astray(first)
    offset = _with_offset(first, task)
    if offset is None:
        shorter = _in_shorter_pieces(first, task)
        return ScrutinisedFit(replace(first, remarks=found) if shorter is None else shorter)
    values = {p.name: p.value for p in offset.parameters if p.name in joint.names}
    again = replace(task, parameters=parameters.with_values(values)).attempt()
    if again is not None and again.misfit < (1 - SETTINGS.better) * first.misfit:
        note = "fitted once more from the parameters of a fit with a constant torque, which simulates it better"
        doubted = tuple(doubts(again, joint, parameters, records))
        return ScrutinisedFit(replace(again, remarks=(*doubted, note, _advice(again, offset))), offset)
    return ScrutinisedFit(replace(first, remarks=(*found, _advice(first, offset))), offset)


def _refuse_astray(fit: FitResult) -> None:
    """Raises NumericsError for a fit whose simulation has nothing to do with any of its records. A motor at rest would
    be nearer."""
    best = max(fit.fit_percent.values())
    if best < SETTINGS.astray:
        raise NumericsError(
            f"the fit of {', '.join(fit.records)} ends with a simulation that is wrong by {plain(1 - best / 100, 2)}"
            " times the motion",
            hint="`robotid check` examines signs, units and columns; or give guesses under robot.parameters",
        )


def doubts(fit: FitResult, joint: Joint, start: Parameters, records: Sequence[Record]) -> Iterator[str]:
    """What speaks against a fit, a sentence each. start : the parameters from which it began."""
    values = np.array([p.value for p in fit.parameters])
    yield from _worse_torque(joint, start, values, records)
    yield from _other_branch(fit, joint, start)
    begun = {record.name: record for record in reversed(records)}  # of a record in pieces, the first state of the first
    for name in fit.records:
        yield from _first_speed(fit, joint, begun[name])


def _worse_torque(joint: Joint, start: Parameters, values: Array, records: Sequence[Record]) -> Iterator[str]:
    for record in records:
        try:
            parallel = ParallelFilter(choose_cutoff(joint, start, record))
        except NumericsError:
            continue
        before, after = (torque_error(joint, start.with_values(v), record, parallel) for v in (start.values, values))
        if after > SETTINGS.torque_factor * before and after > before + SETTINGS.torque_percent:
            yield (
                f"the torque of {record.name} is met to {plain(after)} % by the fit and to {plain(before)} % by its"
                " start: an error of the model went into the parameters, as it does less in short pieces (fit.horizon)"
            )


def _other_branch(fit: FitResult, joint: Joint, start: Parameters) -> Iterator[str]:
    for estimate, value in zip(fit.parameters, start.values, strict=True):
        if (
            not estimate.fixed
            and estimate.remark.startswith("at its")
            and value not in (estimate.lower, estimate.upper)
        ):
            yield f"{estimate.name} ended {estimate.remark}, {estimate.value:.3g}, from a start at {value:.3g}"
    masses = [name for name, place in joint.playing(Role.MASS).items() if not place.term.states]
    if not any(start.free[joint.names.index(name)] for name in masses):
        return
    before = total_inertia(joint, {name: start[name] for name in masses})
    after = total_inertia(joint, {name: fit[name].value for name in masses})
    if before > 0 and not 1 / SETTINGS.inertia_factor < after / before < SETTINGS.inertia_factor:
        yield f"the inertia of the fit is {plain(after / before)} times that of its start, on the motor side"


def _first_speed(fit: FitResult, joint: Joint, record: Record) -> Iterator[str]:
    """A first speed that the measurement alone keeps from going elsewhere."""
    row, measured = joint.motor_speed, float(record.dphi_m[0])
    least, most = (float(limit[row]) for limit in first_state_limits(joint, record))
    speed, margin = float(fit.initial_states[record.name][row]), SETTINGS.at_limit * (most - least)
    if most - least > 0.0 and not least + margin < speed < most - margin:
        unit = unit_of("speed", linear=joint.structure.linear)
        yield (
            f"the estimated first speed of {record.name}, {plain(speed)} {unit}, is as far from the measured one,"
            f" {plain(measured)} {unit}, as its limits allow"
        )


def growth_rate(joint: Joint, theta: Array, record: Record) -> float:
    """Mean over a measured motion of the rate [1/s] at which an error of the simulation grows, zero where it decays."""
    x = measured_guess(joint, theta, record)[:, :: max(1, len(record) // SETTINGS.points)]
    zero = np.zeros(x.shape[1])
    at = joint.evaluate(x, zero, np.sign(x[joint.speeds]), zero, theta, columns=DerivativeColumns())
    rates = np.linalg.eigvals(np.moveaxis(np.asarray(at.A), -1, 0)).real.max(axis=1)
    return float(np.mean(np.maximum(rates, 0.0)))


@dataclass(frozen=True, slots=True)
class _Instability:
    """How errors of an open simulation grow. rate [1/s] : the largest of the records'; growth : factors of e over a
    whole record; horizon [s] : of pieces over which they do not grow far, None where those would be too short."""

    rate: float
    growth: float
    horizon: float | None


def _instability(joint: Joint, parameters: Parameters, records: Sequence[Record]) -> _Instability:
    rates = [growth_rate(joint, parameters.values, record) for record in records]
    growth, rate = max(rate * record.duration for rate, record in zip(rates, records, strict=True)), max(rates)
    horizon = float(f"{SETTINGS.growth / rate:.1g}") if rate > 0.0 else None
    if horizon is not None and _is_too_short(horizon, records):
        horizon = None
    return _Instability(rate, growth, horizon)


def _is_too_short(horizon: float, records: Sequence[Record]) -> bool:
    """Whether pieces of this length [s] would have too few samples in a record."""
    return any(horizon < 2 * SHORTEST_PIECE * record.sampling_time for record in records)


def _nearer_start(task: FitTask) -> FitTask | None:
    """The same from what the initialisation found, of a rigid axis by the regression of its torque on the measured
    motion; None where the given start is not far from there. A motor that too much friction locks, or too large an
    inertia, tells an open simulation nothing of either, nor does a motion far from a resonance tell where that is."""
    found = {name: value for name, value in task.found.items() if name in task.joint.names}
    if not found and task.joint.masses == 1:
        try:
            found = fit_rigid(task.joint, task.parameters, task.records).guesses
        except NumericsError:
            return None
    free = task.parameters.free
    near = np.where(free, task.parameters.with_values(found).values, task.parameters.values)
    near = np.clip(near, task.parameters.lower, task.parameters.upper)
    before, after = np.abs(task.parameters.values), np.abs(near)
    far = np.maximum(before, after) > SETTINGS.start_factor * np.minimum(before, after)
    return replace(task, parameters=task.parameters.with_values(near), found={}, left_out=()) if far.any() else None


def _in_chosen_pieces(task: FitTask) -> ScrutinisedFit:
    """The fit over pieces that the data choose before it, whole records where no error grows far."""
    instability, task = (
        _instability(task.joint, task.parameters, task.records),
        task.with_options(choose_horizon=False),
    )
    horizon = instability.horizon if instability.growth > SETTINGS.growth else None
    if horizon is None:
        found = scrutinised_fit(task)
        far = instability.growth > SETTINGS.growth
        why = "errors grow too fast for any piece" if far else "no error of an open simulation grows far"
        note = f"horizon: auto fits whole records, for {why} on this motion"
        return found if found.fit.horizon else _noted(found, note)
    found = scrutinised_fit(task.with_options(horizon=horizon))
    note = (
        f"horizon: auto fits pieces of {horizon:g} s, for an error of the open simulation grows by a factor of e in"
        f" {1 / instability.rate:.2g} s on this motion"
    )
    return _noted(replace(found, fit=replace(found.fit, horizon=horizon)), note)


def _noted(found: ScrutinisedFit, note: str) -> ScrutinisedFit:
    return replace(found, fit=replace(found.fit, remarks=(*found.fit.remarks, note)))


def _hopeless_as_whole(task: FitTask) -> FitResult | None:
    """The fit over pieces where an open simulation is unstable, and even with what they find one of whole records ends
    farther from some than rest would: no fit of these would come to an end soon, or near. None where that is not so."""
    if task.options.horizon is not None:
        return None
    found = _over_stable_pieces(task, "no simulation of whole records stays near them")
    if found is None or found.end is End.INTERRUPTED:
        return found
    theta = task.parameters.with_values({p.name: p.value for p in found.parameters}).values
    near = (_stays_near(task.joint, theta, record, task.options.output) for record in task.records)
    return None if all(near) else found


def _stays_near(joint: Joint, theta: Array, record: Record, output: Quantity) -> bool:
    """Whether an open simulation of a whole record, from its measured first state, is nearer to it than rest is."""
    try:
        trajectory = simulate(joint, theta, record, max_failed_windows=TRIAL_PATIENCE)
    except NumericsError:
        return False
    return fit_percent(measured_output(record, output), observed(trajectory, output)) > 0.0


def _in_pieces(first: FitResult, task: FitTask) -> FitResult | None:
    """The fit over pieces in which an error cannot grow far, where an open simulation is unstable and they serve."""
    return _over_stable_pieces(task, f"the fit of whole records is {min(first.fit_percent.values()):.1f} %")


def _over_stable_pieces(task: FitTask, whole: str) -> FitResult | None:
    """The fit over pieces in which an error cannot grow far; None where it does not in whole records, or the fit is
    poor. whole : why these are not fitted, in words."""
    instability = _instability(task.joint, task.parameters, task.records)
    horizon = instability.horizon if instability.growth >= SETTINGS.unstable else None
    if horizon is None:
        return None
    found = task.with_options(horizon=horizon).attempt()
    if found is None or min(found.fit_percent.values()) < SETTINGS.poor_fit:
        return None
    remark = (
        f"an error of the open simulation grows by a factor of e in {1 / instability.rate:.2g} s on this motion, and"
        f" {whole}: fitted, validated and diagnosed in pieces of {horizon:g} s"
    )
    return _as_cut(found, horizon, remark, task)


def _as_cut(fit: FitResult, horizon: float, remark: str, task: FitTask) -> FitResult:
    """A fit over pieces of this length [s], with what speaks against it and why it was made so."""
    return replace(fit, horizon=horizon, remarks=(*doubts(fit, task.joint, task.parameters, task.records), remark))


def _in_shorter_pieces(first: FitResult, task: FitTask) -> FitResult | None:
    """The fit over pieces in which it meets the torque as its start does, where a poor one of whole records does not;
    None where none serve, or are not needed.

    On a motion that little damps, an open simulation adds up what is missing, and parameters that keep it near the
    record may be far from those that move the joint.
    """

    def contradicts(fit: FitResult) -> bool:
        values = np.array([p.value for p in fit.parameters])
        return any(_worse_torque(task.joint, task.parameters, values, task.records))

    poor = min(first.fit_percent.values()) < SETTINGS.poor_fit
    if task.options.horizon is not None or not poor or not contradicts(first):
        return None
    duration = min(record.duration for record in task.records)
    for count in SETTINGS.pieces:
        horizon = float(f"{duration / count:.1g}")
        found = None if _is_too_short(horizon, task.records) else task.with_options(horizon=horizon).attempt()
        if found is not None and not contradicts(found):
            remark = (
                f"in pieces of {horizon:g} s the fit meets the torque as its start does, and of whole records it does"
                " not: fitted, validated and diagnosed in such pieces"
            )
            return _as_cut(found, horizon, remark, task)
    return None


def _beside_lacking(task: FitTask) -> FitResult | None:
    """The fit over pieces, where the torque asks for a weight or a constant torque that the model lacks, and an error
    grows far on the measured motion; None where it asks for neither, or no error grows far.

    Of whole records, no simulation of such a motion leads to what is lacking, not even one with it.
    """
    found = list(_regressed_beside(task))
    if not found:
        return None
    try:
        before = _torque_error_percent(fit_rigid(task.joint, task.parameters, task.records))
    except NumericsError:
        return None
    after, what, extended, start = min(found, key=lambda one: one[0])
    if before < SETTINGS.torque_factor * after or before < after + SETTINGS.torque_percent:
        return None
    instability = _instability(extended, start, task.records)
    if instability.growth < SETTINGS.unstable or instability.horizon is None:
        return None
    fit = task.with_options(horizon=instability.horizon).attempt()
    if fit is None:
        return None
    remark = (
        f"with {what}, which the model does not have, the torque is met to {plain(after)} % instead of"
        f" {plain(before)} %, and an error of the open simulation grows by a factor of e in"
        f" {1 / instability.rate:.2g} s: fitted, validated and diagnosed in pieces of {instability.horizon:g} s"
    )
    return _as_cut(fit, instability.horizon, remark, task)


def _torque_error_percent(rigid: RigidResult) -> float:
    return max(rigid.torque_error_percent.values())


def _regressed_beside(task: FitTask) -> Iterator[tuple[float, str, Joint, Parameters]]:
    """Regressions of the torque with a weight and with a constant torque besides, where the model has none and the
    records tell of it: the torque error [%], what is added in words, the extended joint, and its start from there."""
    structure = task.joint.structure
    lacking = {} if OFFSET in structure.terms else {OFFSET: "a constant torque"}
    weight = f"{'motor' if structure.gear_ratio is None else 'arm'}.{WEIGHT}"
    if not structure.linear and not any(name.endswith(f".{WEIGHT}") for name in structure.terms):
        lacking[weight] = "a weight"
    for effect, what in lacking.items():
        with suppress(NumericsError):
            rigid, extended, start = _regressed_with(effect, task)
            yield _torque_error_percent(rigid), what, extended, start


def _regressed_with(effect: str, task: FitTask) -> tuple[RigidResult, Joint, Parameters]:
    extended = assemble(task.joint.structure.extended(effect), angle=task.joint.keeps_angle)
    start = extended.parameters().taken_from(task.parameters)
    rigid = fit_rigid(extended, start, task.records)
    return rigid, extended, start.with_values(rigid.guesses)


def _with_offset(first: FitResult, task: FitTask) -> FitResult | None:
    """The fit with a constant torque free, where it is far better; None where it is not, or has one already."""
    joint = task.joint
    if OFFSET in joint.structure.terms or not task.parameters.free.any():
        return None
    extended = assemble(joint.structure.extended(OFFSET), angle=joint.keeps_angle)
    start = extended.parameters().taken_from(task.parameters)
    other = replace(task, name=first.name + OFFSET_SUFFIX, joint=extended, parameters=start)
    found = other.with_options(other_starts=_by_regression(task)).attempt()
    if found is None:
        return None
    gain = [(found.noise_std[n] / std) ** 2 for n, std in first.noise_std.items() if std > 0]
    if not gain or max(gain) >= SETTINGS.offset_gain:
        return None
    torque = found[f"{OFFSET}.tau0"]
    remark = f"{first.name} with a constant torque of {torque.value:.3g} {torque.unit}, which it does not have"
    return replace(found, horizon=task.options.horizon, remarks=(remark,))


def _by_regression(task: FitTask) -> tuple[Parameters, ...]:
    """The start of a fit with a constant torque that a regression of the torque gives, none where there is none. One
    that is far from nothing moves the motion so far that a simulation without it does not lead there."""
    try:
        return (_regressed_with(OFFSET, task)[2],)
    except NumericsError:
        return ()


def _advice(first: FitResult, offset: FitResult) -> str:
    """What a constant torque would change."""
    torque = offset[f"{OFFSET}.tau0"]
    fits = ", ".join(f"{n} from {first.fit_percent[n]:.1f} to {f:.1f} %" for n, f in offset.fit_percent.items())
    values = ", ".join(
        f"{p.name} = {p.value:.4g} {p.unit}" for p in offset.parameters if not p.fixed and p is not torque
    )
    return (
        f"with a constant torque of {torque.value:.3g} {torque.unit}, which the model does not have, the fit rises"
        f" ({fits}) and gives {values}: add constant_torque to robot.model.motor, or remove the offset of the torque"
    )
