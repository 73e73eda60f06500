"""The diagnosis of a fitted model, from noise to verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.experiment import Experiments, with_experiments
from robotid.diagnosis.results import Diagnosis
from robotid.diagnosis.search.data import Evidence
from robotid.diagnosis.search.search import search
from robotid.diagnosis.verdict import all_explained, explains_all, explains_nothing, not_explained, verdict
from robotid.estimate.fitted_model import FittedModel, fitted_model, simulate_record
from robotid.estimate.result import FitResult
from robotid.signals.record import Record
from robotid.signals.stretches import stretches

Log = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class DiagnosisOptions:
    """How a model is diagnosed.

    horizon [s] : length of the pieces of a record that are simulated afresh, None for whole records. max_samples :
    longer records are sampled in stretches of so many samples in all. experiments : what could be driven to tell causes
    apart that these records do not; None, and no experiment is proposed.
    """

    horizon: float | None = None
    max_samples: int = 100_000
    experiments: Experiments | None = None


def diagnose(
    fit: FitResult | FittedModel,
    records: Sequence[Record],
    criteria: Criteria | None = None,
    options: DiagnosisOptions | None = None,
    log: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Diagnose a fitted model: causes are fitted on the records of its fit and measured on the others.

    records : all of them; those that bear the names of the fit's records are fitted, the others validate. log : is
    called with what is being done. The gains of the causes are those of the search, which weighs a residual by its
    noise; `extension.with_gains` has those of fits as the pipeline makes them.

    Raises NumericsError where the model cannot be simulated.
    """
    model = fit if isinstance(fit, FittedModel) else fitted_model(fit)
    criteria, options = criteria or Criteria(), options or DiagnosisOptions()
    remarks = tuple(_shortened(r, options.max_samples) for r in records if len(r) > options.max_samples)
    for remark in remarks:
        log(remark)
    parts = [part for r in records for part in stretches(r, options.max_samples)]
    simulated = [simulate_record(model, part, options.horizon) for part in parts]
    fitted = [run for run in simulated if run.record.name in model.records]
    if explains_nothing(model, simulated):
        diagnosis = not_explained(model, simulated)
        return replace(diagnosis, remarks=(*diagnosis.remarks, *remarks))
    if explains_all(model, simulated):
        diagnosis = all_explained(model, simulated)
        return replace(diagnosis, remarks=(*diagnosis.remarks, *remarks))
    validation = [part for part in parts if part.name not in model.records]
    found = search(Evidence(model, fitted, validation, options.horizon), criteria, log)
    log("measuring where the misfit sits")
    diagnosis = verdict(model, simulated, found, criteria)
    diagnosis = replace(diagnosis, remarks=(*diagnosis.remarks, *remarks))
    return diagnosis if options.experiments is None else with_experiments(diagnosis, found, options.experiments)


def _shortened(record: Record, samples: int) -> str:
    taken = sum(map(len, stretches(record, samples)))
    return f"{record.name}: {taken} of {len(record)} samples are used, in stretches (diagnose.samples)"
