"""One round of the score: every candidate's columns through a model, and the misfit that each would explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.refitted_model import RefittedModel, Unknowns
from robotid.diagnosis.scoring.candidate import Candidate, EffectCandidate, ForceGradient
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.diagnosis.scoring.projection import Projected, left_over, project
from robotid.diagnosis.scoring.record_change_candidate import RecordChangeCandidate, record_changes
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.diagnosis.scoring.score_test import Score, score, significance
from robotid.diagnosis.scoring.settings import SCORING
from robotid.estimate.residual import state_weights
from robotid.model.structure import RECORD_CHANGE
from robotid.simulation.sensitivities import force_gradient


@dataclass(frozen=True, slots=True, eq=False)
class CandidateScan:
    """A model with the columns of all candidates on every segment of its fit."""

    model: RefittedModel
    candidates: tuple[EffectCandidate, ...]
    scans: tuple[Scan, ...]

    def whitened_as(self, segments: Sequence[Segment]) -> CandidateScan:
        """The same columns under the noise of these segments."""
        pairs = zip(self.scans, segments, strict=True)
        return replace(self, scans=tuple(one.whitened_as(segment) for one, segment in pairs))


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """What the score says of a model.

    model : as it was scanned; scores : of all candidates, best first; inflation : energy of the residual per direction
    that no single candidate explains, in variances of the noise; candidates : in the order of the projected columns.
    """

    model: RefittedModel
    projected: Projected
    scores: tuple[Score, ...]
    inflation: float
    candidates: tuple[Candidate, ...] = ()

    @property
    def by_effect(self) -> dict[str, Score]:
        """The best point of each effect's grid, by name, those that explain nothing among them."""
        return {one.candidate.name: one for one in reversed(self.scores)}

    @property
    def best_of_each(self) -> list[Score]:
        """The best point of each effect's grid, best first."""
        return best_of_each(self.scores)

    def p_value(self, one: Score) -> float:
        """p-value of the best of all candidates; the residual that other candidates could explain counts as noise."""
        tries, k = len(self.scores), len(one.amplitude)
        white = significance(one.energy, k, self.projected.energy, self.model.samples, tries)
        coloured = significance(one.energy, k, one.energy + self.inflation * tries, tries, tries)
        return max(white, coloured)


def missing_effects(model: RefittedModel, skip: Sequence[str]) -> tuple[EffectCandidate, ...]:
    """All effects that a model lacks, those that read a companion of its records among them. skip : effects that are
    out of the question."""
    records = [segment.record for segment in (*model.fitted, *model.validation)]
    return candidates(model.structure, model.output, skip, records)


def scan_candidates(model: RefittedModel, skip: Sequence[str]) -> CandidateScan:
    """All candidates' columns through a model. skip : effects that are out of the question."""
    missing = missing_effects(model, skip)
    return CandidateScan(model, missing, scans(model.fitted, model.unknowns, missing))


def with_residuals_of(
    model: RefittedModel, missing: tuple[EffectCandidate, ...], before: Sequence[Scan]
) -> CandidateScan:
    """A model that differs little from the one whose columns these are: its residuals beside the same columns."""
    pairs = zip(before, model.fitted, strict=True)
    return CandidateScan(model, missing, tuple(one.with_segment(segment) for one, segment in pairs))


def rank(scan: CandidateScan, criteria: Criteria) -> Round:
    """All candidates by what they would explain, refined where grids do not hold their shapes, and every parameter as
    different in each record."""
    model, seen = scan.model, scan.scans
    changes = _record_changes(model) if RECORD_CHANGE not in criteria.skip else ()
    refined = refine(scan.candidates, misfit_gradients(scan))
    if refined:
        further = scans(model.fitted, Unknowns(model.output), refined)
        seen = tuple(one.with_columns(more.signals[:-1]) for one, more in zip(seen, further, strict=True))
    projected, tried = project(seen, changes), (*scan.candidates, *refined, *changes)
    scores = tuple(score(projected, tried))
    return Round(model, projected, scores, _inflation(projected, best_of_each(scores)), tried)


def misfit_gradients(scan: CandidateScan) -> list[ForceGradient]:
    """What the whitened residual of each segment, less what the fit could still take, gains from a generalised force at
    each sample."""
    found = []
    for one, left in zip(scan.scans, left_over(scan.scans), strict=True):
        segment, weights = one.segment, one.whitening.transposed(left)
        row, weights = state_weights(segment.trajectory, scan.model.output, weights)
        found.append(ForceGradient(segment, force_gradient(segment.trajectory, row, weights)))
    return found


def refine(missing: Sequence[EffectCandidate], gradients: Sequence[ForceGradient]) -> tuple[EffectCandidate, ...]:
    """Further points for the candidates that a grid cannot hold, one family after the other."""
    families = {one.family: one for one in missing if one.family is not None}
    return tuple(point for one in families.values() for point in one.refine(gradients))


def best_of_each(scores: Sequence[Score]) -> list[Score]:
    """The best point of each effect's grid, best first."""
    found: dict[str, Score] = {}
    for one in scores:
        if one.energy > 0:
            found.setdefault(one.candidate.name, one)
    return list(found.values())


def _record_changes(model: RefittedModel) -> tuple[RecordChangeCandidate, ...]:
    """Of a single record, nothing could show what changed."""
    names = list(dict.fromkeys(one.record.name for one in model.fitted))
    return record_changes(model.joint, model.columns, names) if len(names) > 1 else ()


def _inflation(projected: Projected, best: Sequence[Score]) -> float:
    """Mean energy of the residual along the directions that candidates reach and the best of them does not."""
    u, values, _ = np.linalg.svd(projected.missing / np.where(projected.length > 0, projected.length, 1.0))
    reached = u[:, : int(np.sum(values > SCORING.dependent * values[0]))].T @ projected.residual
    taken, k = (best[0].energy, len(best[0].amplitude)) if best else (0.0, 0)
    return max(1.0, (float(reached @ reached) - taken) / max(1, len(reached) - k))
