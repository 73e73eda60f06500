"""What a fitted model lacks, and the model that has it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from robotid.diagnosis import Criteria, Diagnosis, DiagnosisOptions
from robotid.diagnosis.experiment import Experiments
from robotid.errors import ConfigError
from robotid.extension import Extension, diagnose_with_gains, effects_to_add, extension_task
from robotid.extension import extend as extend_model
from robotid.interface.dataset import Dataset, as_dataset
from robotid.interface.identification import Fit, extended_fit, fields_of, with_more
from robotid.parallel import computing
from robotid.signals.record import Record, usable_horizon
from robotid.stages.experiments import references

Log = Callable[[str], None]
"""Is called with what is being done, a line at a time."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class DiagnosedFit(Diagnosis):
    """A diagnosis with the fit and the records that it is of. dataset : those of the fit, and those held out."""

    fit: Fit = field(kw_only=True)
    dataset: Dataset = field(kw_only=True)

    @property
    def result(self) -> Diagnosis:
        """The diagnosis itself, as an artifact keeps it."""
        return Diagnosis(**fields_of(self, Diagnosis))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ExtendedFit(Extension):
    """An extension whose fit can be validated, diagnosed and extended in its turn: `better.fit`. origin : the fit that
    was extended."""

    fit: Fit
    origin: Fit = field(kw_only=True)

    @property
    def result(self) -> Extension:
        """The extension itself, as an artifact keeps it."""
        return Extension(**(fields_of(self, Extension) | {"fit": self.fit.result}))


def diagnose(
    fit: Fit,
    records: Record | Iterable[Record] = (),
    *,
    held_out: Record | Iterable[Record] = (),
    criteria: Criteria | None = None,
    budget: float | None = None,
    jobs: int | None = 1,
    log: Log | None = None,
) -> DiagnosedFit:
    """Find what a fitted model gets wrong, and the effect that it lacks, as `robotid diagnose` does.

    Causes are fitted on the records of the fit, and what they gain is measured on records that it has not seen.

    held_out, records : such records, besides those of role "validate" that the fit was given; without any, no gain can
    be measured. criteria : what is asked of a cause. budget [s] : after which the best answer so far is given, None for
    all the time it takes; the remarks then state what was not examined. jobs : processes, None for one a core; the
    result does not depend on it. log : is called with what is being done, such as `print`.

    Raises ConfigError for two records of one name, NumericsError where the model cannot be simulated.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> fit = rid.fit(rid.Model(motor=["inertia", "viscous", "coulomb"]), rid.read(motor_log(), name="log"))
    >>> found = rid.diagnose(fit, held_out=rid.read(motor_log(seed=2), name="day2"))
    >>> found.verdict, [cause.effect for cause in found.causes]
    ('clean', [])
    """
    data = with_more(fit, as_dataset(held_out) + as_dataset(records))
    experiments = Experiments(references, None)
    options = DiagnosisOptions(horizon=_horizon(fit, data), experiments=experiments, budget=budget)
    of_fits = replace(fit.options, horizon=options.horizon).fit
    with computing(jobs):
        found = diagnose_with_gains(fit.fitted_model, fit, data.records, of_fits, criteria, options, log or _silent)
    return DiagnosedFit(**fields_of(found, Diagnosis), fit=fit, dataset=data)


def extend(
    fit: Fit,
    found: DiagnosedFit,
    *,
    effects: Sequence[str] | None = None,
    jobs: int | None = 1,
    log: Log | None = None,
) -> ExtendedFit:
    """Extend a fitted model by the causes of its diagnosis and measure the gain on every record. By all causes it is
    the fit that the diagnosis has made of them already, by others one anew.

    effects : by dotted name, such as "motor.stribeck", instead of the causes that were found. An effect without which
    the records held out are simulated as well is dropped again. jobs : processes, None for one a core. log : is called
    with what is being done.

    Raises ConfigError for a diagnosis of another fit or an effect that the model cannot have, NumericsError where the
    extended model does not converge.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> fit = rid.fit(rid.Model(motor=["inertia", "viscous", "coulomb"]), rid.read(motor_log(), name="log"))
    >>> found = rid.diagnose(fit, held_out=rid.read(motor_log(seed=2), name="day2"))
    >>> rid.extend(fit, found).added                     # there is nothing that it lacks
    ()
    """
    if not isinstance(found, DiagnosedFit) or found.fit is not fit:
        raise ConfigError(
            "this is no diagnosis of this fit", where="extend", hint="give what rid.diagnose(fit) returns"
        )
    wanted = effects_to_add(found, fit) if effects is None else tuple(effects)
    if effects is not None:
        for effect in wanted:
            if effect in fit.structure.effects:
                raise ConfigError(f"{effect} is in the model already", where="extend", hint="leave it out")
        fit.model.with_effects(*wanted)
    data, horizon = found.dataset, _horizon(fit, found.dataset)
    of_fits = replace(fit.options, horizon=horizon).fit
    task = extension_task(found, fit, data.records, of_fits, horizon=horizon, log=log or _silent)
    with computing(jobs):
        result = extend_model(replace(task, known=found.extended), wanted)
    after = extended_fit(fit, result.fit, found.dataset)
    return ExtendedFit(**(fields_of(result, Extension) | {"fit": after}), origin=fit)


def _horizon(fit: Fit, data: Dataset) -> float | None:
    """The length of pieces [s] of a fit, which may have chosen it, where all of these records can be cut by it, too."""
    return usable_horizon(fit.options.fixed_horizon, data.records)


def _silent(_: str) -> None:
    """What is done is reported to nobody."""
