"""Fits with a constant torque or a weight that the model does not have, the commonest things that it lacks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate.result import FitResult
from robotid.estimate.rigid import RigidResult, fit_rigid
from robotid.estimate.scrutiny.instability import instability_of
from robotid.estimate.scrutiny.pieces import as_cut
from robotid.estimate.scrutiny.settings import SETTINGS
from robotid.estimate.scrutiny.task import FitTask
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.numerals import plain

WEIGHT = "gravity"
OFFSET, OFFSET_SUFFIX = "motor.constant_torque", "_offset"


def with_offset(first: FitResult, task: FitTask) -> FitResult | None:
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


def advice(first: FitResult, offset: FitResult) -> str:
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


def beside_lacking(task: FitTask) -> FitResult | None:
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
    instability = instability_of(extended, start, task.records)
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
    return as_cut(fit, instability.horizon, remark, task)


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
