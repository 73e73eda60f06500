"""The first state of a search: the records of a model, and the noise that shows behind it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.noise_estimate import Explained, NoiseEstimate, TorqueErrors, estimate_noise
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment, with_typical_noise
from robotid.diagnosis.nonparametric.curve_fit import free_forces
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import AS_IT_IS, CAREFUL, refit, unknowns_of
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, Trajectories, Unknowns, segment_fit
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.diagnosis.scoring.ranking import scan_candidates, with_residuals_of
from robotid.diagnosis.scoring.scan import Scan, scan, scans
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.search.state import SearchState
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel, Simulated, simulate_records
from robotid.estimate.residual import OutputError
from robotid.signals.record import Quantity, Record

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a search is given: a model as simulated on the records of its fit, and the validation records.

    horizon [s] : length of the pieces of a record that start afresh, None for whole records.
    """

    model: FittedModel
    fitted: Sequence[Simulated]
    validation: Sequence[Record]
    horizon: float | None = None

    def on(self, changed: Callable[[Record], Record]) -> Evidence:
        """The same of changed records, the model fitted to those of them that it was fitted to; records that stay as
        they are, are returned as they are. Raises NumericsError where it cannot be simulated on them."""
        records = [changed(run.record) for run in self.fitted]
        validation = [changed(record) for record in self.validation]
        same = all(record is run.record for record, run in zip(records, self.fitted, strict=True))
        model = self.model if same else _fitted_to(records, self)
        fitted = simulate_records(model, records, self.horizon)
        return replace(self, model=model, fitted=fitted, validation=validation)

    def in_pieces(self, horizon: float) -> Evidence:
        """The same in pieces of this length [s]. Raises NumericsError where the model cannot be simulated on them."""
        fitted = simulate_records(self.model, [run.record for run in self.fitted], horizon)
        return replace(self, fitted=fitted, horizon=horizon)


def _fitted_to(records: Sequence[Record], evidence: Evidence) -> FittedModel:
    """The model of the evidence fitted to other records, by plain least squares of the output as fits are: the noise
    behind parameters that something else has led astray is not known."""
    model = evidence.model
    data = unweighted(model, records, evidence.horizon)
    refitted = refit(model.joint.structure, [model.parameters], data, options=CAREFUL)
    return replace(model, parameters=refitted.parameters, first_states={})


def unweighted(model: FittedModel, records: Sequence[Record], horizon: float | None) -> EvaluationData:
    """Records to be fitted by plain least squares of a model's output, as before the noise is known. horizon [s] : of
    their pieces, None for whole records."""
    pieces = [piece for record in records for piece in record.pieces(horizon)]
    return EvaluationData(
        fitted=tuple(Segment(piece, UNIT_WHITENING) for piece in pieces),
        validation=(),
        output=model.output,
        estimate_states=model.estimate_states,
        noise_reached=False,
        torque_errors=None,
    )


def first_state(evidence: Evidence, criteria: Criteria, *, torque_errors: TorqueErrors = None) -> SearchState:
    """The state in which a search begins: the noise found in the residuals, the model refitted through its whitening,
    and the columns of all candidates. Where the refit cannot simulate all records, the model stays as it is.

    torque_errors : which errors of the torque are part of the noise. Raises NumericsError where the model cannot be
    simulated.
    """
    model = evidence.model
    found = [segment for run in evidence.fitted for segment in run.segments(model.output)]
    simulated = [segment_fit(Segment(s.record, UNIT_WHITENING), s.trajectory, model.output) for s in found]
    unknowns = _unknowns(model)
    records = [*(one.record for one in simulated), *evidence.validation]
    missing = candidates(model.joint.structure, model.output, criteria.skip, records)
    seen = scans(simulated, unknowns, missing)
    noise = _noise(seen, model.output, torque_errors=torque_errors)
    pieces = [piece for r in evidence.validation for piece in r.pieces(evidence.horizon)]
    data = EvaluationData(
        fitted=noise.segments,
        validation=with_typical_noise(noise.segments, pieces, model.joint, model.theta, model.output),
        output=model.output,
        estimate_states=model.estimate_states,
        noise_reached=noise.reached,
        torque_errors=torque_errors,
    )
    near = Trajectories(tuple(one.trajectory for one in simulated))
    try:
        first = refit(model.joint.structure, [model.parameters], data, near, CAREFUL)
    except NumericsError:  # the whitening has led it where some record runs away
        first = refit(model.joint.structure, [model.parameters], data, near, AS_IT_IS)
    unchanged = _is_unchanged(simulated, first)
    columns = with_residuals_of(first, missing, seen) if unchanged else scan_candidates(first, criteria.skip)
    recorded = tuple(run.record for run in evidence.fitted)
    return SearchState(first, first, data, columns, start=model.start, recorded=recorded)


def settled_state(evidence: Evidence, criteria: Criteria) -> SearchState:
    """The first state beside coloured errors of the torque, as they show behind a model that was fitted beside them: a
    fit that knows nothing of them leads its parameters astray, and what that leaves would count as errors, too.

    Raises NumericsError where the model cannot be simulated.
    """

    def renewed(state: SearchState) -> SearchState:
        state = renew_noise(state)
        return replace(state.with_model(state.model, criteria), first=state.model)

    return settled(
        first_state(evidence, criteria, torque_errors="coloured"),
        renewed,
        lambda state: _torque_noise(state.data.fitted),
    )


def settled(state: T, renewed: Callable[[T], T], noise: Callable[[T], float]) -> T:
    """What comes of a state by renewals, until these hardly lower its noise."""
    for _ in range(ACCEPTANCE.noise_renewals):
        before, state = noise(state), renewed(state)
        if noise(state) > ACCEPTANCE.settled_noise * before:
            break
    return state


def renew_noise(state: SearchState) -> SearchState:
    """The state with the noise as it shows behind its model, never larger, and the model refitted through it; as it was
    where that leads the model astray, so that it cannot be simulated or, by the noise before, loses a good part of what
    causes explain: what is left of an event may do so."""
    model, data = state.model, state.data
    noise = _noise(state.scan.scans, data.output, torque_errors=data.torque_errors)
    if _torque_noise(noise.segments) <= _torque_noise(data.fitted):
        records = [segment.record for segment in data.validation]
        typical = with_typical_noise(noise.segments, records, model.joint, model.parameters.values, data.output)
        data = replace(data, fitted=noise.segments, validation=typical)
    try:
        refitted = refit(model.structure, [model.parameters], data, model.trajectories, CAREFUL)
    except NumericsError:
        return state
    before, by_old, at = (state.data.fitted_energy(one.fitted) for one in (state.first, refitted, model))
    if state.causes and by_old - at > ACCEPTANCE.unknown_share * max(0.0, before - at):
        return state
    return replace(state, model=refitted, data=data, scan=state.scan.whitened_as(data.fitted))


def _unknowns(model: FittedModel) -> Unknowns:
    nothing = np.zeros(0)
    return unknowns_of(OutputError(model.joint, model.parameters, (), model.output, nothing, model.estimate_states))


def _is_unchanged(before: Sequence[SegmentFit], after: RefittedModel) -> bool:
    """Whether a refit has changed so little of the residuals that columns through the model before serve as well."""
    pairs = zip(before, after.fitted, strict=True)
    energy = sum(Segment(new.record, new.whitening).energy(new.residual - old.residual) for old, new in pairs)
    return energy < ACCEPTANCE.unchanged_share * after.energy


def _noise(seen: Sequence[Scan], output: Quantity, *, torque_errors: TorqueErrors) -> NoiseEstimate:
    """The noise in the residuals of scanned segments, all that candidates and free curves explain set aside."""

    def with_curves() -> Explained:
        curves = (scan(one.segment, one.unknowns, (), free_forces(one.segment)) for one in seen)
        return _explained([one.with_columns(own.signals[:-1]) for one, own in zip(seen, curves, strict=True)])

    segments = [one.segment for one in seen]
    return estimate_noise(segments, _explained(seen), with_curves, output, torque_errors=torque_errors)


def _explained(seen: Sequence[Scan]) -> Explained:
    return Explained(tuple(one.signals[:-1] for one in seen), tuple(one.unexplained() for one in seen))


def _torque_noise(segments: Sequence[Segment]) -> float:
    """Variance of the torque's noise, white and red [Nm2]."""
    levels = [segment.whitening.levels for segment in segments]
    return max(one.torque + one.red for one in levels)
