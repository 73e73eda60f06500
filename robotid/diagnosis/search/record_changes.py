"""What differs on records held out: one parameter at a time, found on their first half and measured on the second."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robotid.catalogue import assemble
from robotid.diagnosis.noise.whitening import Whitening
from robotid.diagnosis.refit.refitted_model import PATIENCE, TOLERANCE, EvaluationData, RefittedModel, carried
from robotid.diagnosis.scoring.candidates import Candidate, differences
from robotid.diagnosis.scoring.score_test import significance
from robotid.errors import NumericsError
from robotid.estimate.least_squares import SolveOptions, solve
from robotid.estimate.residual import Evaluation, OutputError, measured_output, observed
from robotid.model.units import on_axis
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Record

LOUD = 2.0  # energy a sample, over that of the fitted records, from which a record asks for a reason
CONFIRMED = 0.2  # of the second half's misfit that a difference must remove
ALIKE = 0.02  # of the misfit: differences closer than that are not told apart
MOST_ITERATIONS = 6


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """A parameter that differs on a held-out record. explained : share of the misfit's energy on the second half that
    it removes; gain : of fit there [%]; twins : what explains as much, itself first."""

    effect: str
    value: float
    unit: str
    explained: float
    gain: float
    p_value: float
    twins: tuple[str, ...]


def changes(trial: RefittedModel, bench: EvaluationData) -> tuple[Change, ...]:
    """At most one difference for each held-out record that is simulated clearly worse than the fitted ones."""
    usual = max(1.0, trial.energy / bench.samples)
    found: dict[str, Change] = {}
    for record, whiten in zip(bench.held, bench.whiten_held, strict=True):
        half = len(record) // 2
        parts = (record.piece(0, half), record.piece(half, len(record)))
        before = [_run(trial, None, None, part, whiten) for part in parts]
        if before[1] is not None and 2.0 * before[1].cost > LOUD * usual * len(parts[1]):
            change = _best(trial, parts, whiten, before[1], usual)
            if change is not None and record.name not in found:
                found[record.name] = change
    return tuple(found.values())


def _best(
    trial: RefittedModel, parts: tuple[Record, Record], whiten: Whitening, before: Evaluation, usual: float
) -> Change | None:
    """The difference that carries over best from the first part of a record to the second."""
    misfit = 2.0 * before.cost - usual * len(parts[1])
    tried = []
    for candidate in differences(trial.problem.joint, trial.problem.columns, [parts[0].name]):
        found = _run(trial, candidate, None, parts[0], whiten)
        value = None if found is None else float(found.unknowns[0])
        after = None if value is None else _run(trial, candidate, value, parts[1], whiten)
        if value is not None and after is not None:
            tried.append((2.0 * (before.cost - after.cost) / misfit, candidate, value, after))
    tried.sort(key=lambda one: -one[0])
    if not tried or tried[0][0] < CONFIRMED:
        return None
    explained, candidate, value, after = tried[0]
    return Change(
        effect=candidate.name,
        value=value,
        unit=on_axis(linear=trial.structure.linear)(candidate.effect.parameters[0].unit),
        explained=min(1.0, explained),
        gain=_fit(after, parts[1], trial) - _fit(before, parts[1], trial),
        p_value=significance(explained * misfit / usual, 1, 2.0 * before.cost / usual, len(parts[1]), len(tried)),
        twins=tuple(one.name for share, one, *_ in tried if share > explained - ALIKE),
    )


def _run(
    trial: RefittedModel, candidate: Candidate | None, value: float | None, record: Record, whiten: Whitening
) -> Evaluation | None:
    """A record with the parameters held, but for a difference that is sought unless it is given; None on divergence."""
    structure = trial.structure if candidate is None else trial.structure.extended(candidate.name)
    start = {} if candidate is None or value is None else {candidate.name: value}
    parameters = carried(trial.parameters, structure, start)
    sought = [value is None and candidate is not None and name == candidate.name for name in parameters.names]
    parameters = replace(parameters, free=np.array(sought))
    old = trial.problem
    joint = assemble(structure, angle=old.output == "position")
    problem = OutputError(
        joint, parameters, (record,), old.output, np.ones(1), old.estimate_states, (whiten,), PATIENCE
    )
    try:
        return solve(problem, problem.start(), SolveOptions(MOST_ITERATIONS, TOLERANCE)).evaluation
    except NumericsError:
        return None


def _fit(evaluation: Evaluation, record: Record, trial: RefittedModel) -> float:
    output = trial.problem.output
    return fit_percent(measured_output(record, output), observed(evaluation.trajectories[0], output))
