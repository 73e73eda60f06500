"""One clean machine under a condition: the p-value of every effect of the catalogue being absent, which all are."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from robotid.diagnosis.clock import in_time
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.scoring.candidate import columns_of
from robotid.diagnosis.scoring.projection import project
from robotid.diagnosis.scoring.ranking import CandidateScan
from robotid.diagnosis.search.coloured import by_noise, left_by
from robotid.diagnosis.search.data import Evidence
from robotid.errors import RobotidError
from robotid.estimate.fitted_model import fitted_model, simulate_records
from robotid.pipeline.execute import execute
from study.conditional.plan import Spec
from study.conditional.trial import prepared
from study.trials.tool import fit


@dataclass(frozen=True, slots=True)
class Result:
    """alone : p-value of the first point of each effect's grid, by the effect's name, not allowing for the others;
    best : the smallest of all points, allowing for all; error : why the trial ended early."""

    key: str
    condition: str
    alone: dict[str, float]
    best: float = 1.0
    error: str = ""


def run(spec: Spec, folder: Path) -> Result:
    """Fit the clean machine, and test every effect on what the fit leaves, to first order."""
    try:
        return _tested(spec, folder)
    except RobotidError as error:
        return Result(spec.key, spec.condition, {}, error=f"{type(error).__name__}: {error}")


def _tested(spec: Spec, folder: Path) -> Result:
    case, _ = prepared(spec)
    case.write(folder / "records")
    fitted, criteria = fit(folder / "records" / "base.yaml"), Criteria()
    records = execute(fitted.run, "collect").content.records
    fits = execute(fitted.run, "fit").content
    model = fitted_model(fits.models[fits.best])
    fitted_to = [record for record in records if record.name in model.records]
    held_out = [record for record in records if record.name not in model.records]
    evidence = Evidence(model, simulate_records(model, fitted_to), held_out)
    state = in_time(evidence, criteria).start
    left = left_by(state.model)
    scan = CandidateScan(state.model, state.scan.candidates, state.scan.scans).whitened_as(left.noise.segments)
    projected = project(scan.scans)
    points, effects = len(scan.candidates), len({one.name for one in scan.candidates})
    alone, best = dict[str, float](), 1.0
    for one, own in zip(scan.candidates, columns_of(scan.candidates), strict=True):
        blocks = projected.beside_fitted(own)
        at = range(len(projected.fitted), blocks.moment.shape[1])
        noise = by_noise(blocks, at, left.energy, state.model.samples)
        again = blocks.significance(at)
        alone.setdefault(one.name, max(noise, again))
        best = min(best, max(points * noise, effects * again))
    return Result(spec.key, spec.condition, alone, best)
