"""A fit, and what it is tried again with where it cannot be believed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.result import End, FitResult
from robotid.estimate.rigid import fit_rigid
from robotid.estimate.scrutiny.doubts import doubts
from robotid.estimate.scrutiny.instability import instability_of
from robotid.estimate.scrutiny.lacking import advice, beside_lacking, with_offset
from robotid.estimate.scrutiny.pieces import hopeless_as_whole, in_pieces, in_shorter_pieces
from robotid.estimate.scrutiny.settings import SETTINGS
from robotid.estimate.scrutiny.task import FitTask, ScrutinisedFit, noted
from robotid.interrupt import INTERRUPTS
from robotid.numerals import plain

LEFT_OUT = "what a frequency response asks for was left out of the start; the fit that starts from it simulates better"
FAR_START = "fitted once more from what the initialisation found, far from the start that was given"


def scrutinised_fit(task: FitTask) -> ScrutinisedFit:
    """The fit of `fit_model`, with `remarks` on what makes it doubtful, and on what a constant torque would change.

    A doubtful fit is tried again from its start with a constant torque free. Where that explains the records far
    better, the declared model is fitted once more from there, and the better of its two fits is kept. Of a task that is
    interrupted after its first fit, this fit is kept.
    """
    if task.options.choose_horizon:
        return _in_chosen_pieces(task)
    hopeless = hopeless_as_whole(task)
    if hopeless is not None:
        return ScrutinisedFit(hopeless)
    try:
        first, begun = _first_fit(task)
    except NumericsError:
        nearer = _nearer_start(task)
        if nearer is None:
            raise
        return noted(scrutinised_fit(nearer), FAR_START)
    found = ScrutinisedFit(first)
    if first.end is not End.INTERRUPTED:
        try:
            found = _scrutinised(first, begun.with_options(interruptible=False))
        except INTERRUPTS:
            if not task.options.interruptible:
                raise
            found = ScrutinisedFit(replace(first, end=End.INTERRUPTED))
    return found if begun.parameters is task.parameters else noted(found, LEFT_OUT)


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
        return noted(_scrutinised(again, nearer), FAR_START)
    if task.options.horizon is None and min(first.fit_percent.values()) < SETTINGS.poor_fit:
        stable = in_pieces(first, task)
        if stable is not None:
            return ScrutinisedFit(stable)
        beside = beside_lacking(task)
        if beside is not None:
            return ScrutinisedFit(beside)
    _refuse_astray(first)
    offset = with_offset(first, task)
    if offset is None:
        shorter = in_shorter_pieces(first, task)
        return ScrutinisedFit(replace(first, remarks=found) if shorter is None else shorter)
    values = {p.name: p.value for p in offset.parameters if p.name in joint.names}
    again = replace(task, parameters=parameters.with_values(values)).attempt()
    if again is not None and again.misfit < (1 - SETTINGS.better) * first.misfit:
        note = "fitted once more from the parameters of a fit with a constant torque, which simulates it better"
        doubted = tuple(doubts(again, joint, parameters, records))
        return ScrutinisedFit(replace(again, remarks=(*doubted, note, advice(again, offset))), offset)
    return ScrutinisedFit(replace(first, remarks=(*found, advice(first, offset))), offset)


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
        instability_of(task.joint, task.parameters, task.records),
        task.with_options(choose_horizon=False),
    )
    horizon = instability.horizon if instability.growth > SETTINGS.growth else None
    if horizon is None:
        found = scrutinised_fit(task)
        far = instability.growth > SETTINGS.growth
        why = "errors grow too fast for any piece" if far else "no error of an open simulation grows far"
        note = f"horizon: auto fits whole records, for {why} on this motion"
        return found if found.fit.horizon else noted(found, note)
    found = scrutinised_fit(task.with_options(horizon=horizon))
    note = (
        f"horizon: auto fits pieces of {horizon:g} s, for an error of the open simulation grows by a factor of e in"
        f" {1 / instability.rate:.2g} s on this motion"
    )
    return noted(replace(found, fit=replace(found.fit, horizon=horizon)), note)
