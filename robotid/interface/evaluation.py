"""What a fitted model is worth: simulated on a record, and validated on all."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from robotid.config.suggest import suggest
from robotid.display import Displayed
from robotid.errors import ConfigError
from robotid.estimate.fitted_model import FittedModel, Simulated, simulate_record
from robotid.estimate.residual import measured_output
from robotid.estimate.result import Fits
from robotid.estimate.sensing import joint_for
from robotid.interface.dataset import Dataset, as_dataset
from robotid.interface.identification import Fit, with_more
from robotid.interface.model import Model
from robotid.model.array import Array
from robotid.model.units import on_axis
from robotid.numerals import fixed, number
from robotid.parallel import computing
from robotid.report.display import Columns, View, shows
from robotid.report.figures import draw_traces
from robotid.report.tables.table import Table
from robotid.signals.metrics import fit_percent, rmse
from robotid.signals.record import Quantity, Record
from robotid.signals.trace import downsampled
from robotid.simulation.trajectory import Trajectory
from robotid.validation import Validation, ValidationOptions, initial_name, validate_models

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PERTURBATION = 20.0  # [%] by which each parameter is changed in turn, as in Table 3 of the paper


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Simulation(Displayed):
    """A simulated record. record : as measured; output : what is compared, "speed" or "position"; trajectories : one a
    piece that was simulated afresh."""

    record: Record
    output: Quantity
    unit: str
    trajectories: tuple[Trajectory, ...]
    simulated: Array

    @property
    def t(self) -> Array:
        """Time since the experiment began [s], (n,)."""
        return self.record.t

    @property
    def measured(self) -> Array:
        """The measured output, (n,)."""
        edges = np.cumsum([0, *(len(t.u) for t in self.trajectories)]).tolist()
        pieces = [self.record.piece(a, b) for a, b in pairwise(edges)]
        return np.concatenate([measured_output(piece, self.output) for piece in pieces])

    @property
    def residual(self) -> Array:
        """Measured minus simulated output, (n,)."""
        return self.measured - self.simulated

    @property
    def fit_percent(self) -> float:
        """The fit of eq. (15) [%]: 100 is perfect, 0 no better than the mean."""
        return fit_percent(self.measured, self.simulated)

    @property
    def rmse(self) -> float:
        """Root mean square of the residual, in the unit of the output."""
        return rmse(self.measured, self.simulated)


def simulate(
    model: Model | Fit,
    record: Record | Dataset,
    parameters: Mapping[str, float] | None = None,
    *,
    horizon: float | None = None,
) -> Simulation:
    """Simulate one record in open loop: the recorded torque drives the model, from the first state that suits it best.

    model : a fit, or a model all of whose parameters have values. parameters : values by dotted name, in SI, which
    replace those of a fit or a model. record : one record, or a dataset of one. horizon [s] : length of the pieces that
    start afresh, None for the whole record.

    Raises ConfigError where a value is missing, NumericsError where the simulation diverges.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> model = rid.Model(motor=["inertia", "viscous", "coulomb"])
    >>> values = {"motor.inertia.J": 0.012, "motor.viscous.Fv": 0.013, "motor.coulomb.Fc": 0.6}
    >>> run = rid.simulate(model, rid.read(motor_log()), values)
    >>> run.simulated.shape, run.fit_percent > 90
    ((2000,), True)
    """
    one = record if isinstance(record, Record) else _only(record)
    ready = _with_values(model, one, parameters or {})
    with computing():
        run: Simulated = simulate_record(ready, one, horizon)
    return Simulation(one, ready.output, ready.unit, run.trajectories, run.signal(ready.output))


def validate(
    fit: Fit,
    records: Record | Iterable[Record] = (),
    *,
    horizon: float | None = None,
    perturbation: float | None = PERTURBATION,
    jobs: int | None = 1,
) -> Validation:
    """Validate a fitted model, and the one from which the fit started, m0.

    records : further ones that the fit has not seen, besides those of the fit and those that it kept. horizon [s] :
    length of the pieces that are simulated afresh, None for whole records. perturbation [%] : by which each parameter
    is changed in turn, None for not at all. jobs : processes, None for one a core.

    Raises ConfigError for two records of one name.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> fit = rid.fit(rid.Model(motor=["inertia", "viscous", "coulomb"]), rid.read(motor_log(), name="log"))
    >>> found = rid.validate(fit, rid.read(motor_log(seed=2), name="day2", role="validate"), perturbation=None)
    >>> sorted(found.models["m1"].records)
    ['day2', 'log']
    """
    data = with_more(fit, as_dataset(records))
    joint = joint_for(fit.structure, fit.output, data)
    fits = Fits({fit.name: fit}, fit.name)
    initial = FittedModel(initial_name(fits), joint, fit.initial, fit.output, (), {}, estimate_states=False)
    start = fit.options.start
    options = ValidationOptions(perturbation, horizon, None, start.cutoff, start.order, start.min_speed)
    frfs = fit.flex.frfs if fit.flex is not None else ()
    models = {initial.name: initial, fit.name: fit.fitted_model}
    with computing(jobs):
        return validate_models(models, fits, data.records, frfs, options)


def _only(records: Dataset) -> Record:
    data = as_dataset(records)
    if len(data) != 1:
        what = f"one record is simulated at a time, found {len(data)}"
        raise ConfigError(what, where="simulate", hint=f"choose one: {', '.join(data.names)}" if len(data) else "")
    return data[0]


def _with_values(model: Model | Fit, record: Record, values: Mapping[str, float]) -> FittedModel:
    """A model ready to be simulated on a record. Raises ConfigError for values that are missing or unknown."""
    if isinstance(model, Fit):
        ready, missing = model.fitted_model, list[str]()
    else:
        joint, known = joint_for(model.structure, "speed", (record,)), model.knowledge
        parameters = joint.parameters().with_known(known)
        ready = FittedModel(model.name, joint, parameters, "speed", (), {})
        given = {*values, *(name for name, one in known.items() if one.guess is not None), *model.structure.changes}
        missing = [name for name in joint.names if name not in given]
    for name in values:
        if name not in ready.joint.names:
            hint = suggest(name, ready.joint.names)
            raise ConfigError(f'the model has no parameter "{name}"', where="simulate", hint=hint)
    if missing:
        hint = "give it in parameters={...}, or simulate a fit"
        raise ConfigError(f"a value is missing for {', '.join(missing)}", where="simulate", hint=hint)
    numbers = {name: float(value) for name, value in values.items()}
    if not np.isfinite(list(numbers.values())).all():
        raise ConfigError("a value is not a number", where="simulate", hint="check parameters={...}")
    return replace(ready, parameters=ready.parameters.with_values(numbers), first_states={})


@shows(Simulation)
class SimulationView(View[Simulation]):
    """Measured and simulated output."""

    def line(self) -> str:
        return f"{self.content.record.name}, fit {fixed(self.content.fit_percent)} %"

    def tables(self) -> Sequence[Table]:
        s = self.content
        row = (s.record.name, s.output, fixed(s.fit_percent), number(s.rmse), s.unit)
        return (Table("Simulation", ("record", "output", "fit [%]", "RMSE", "unit"), (row,)),)

    def columns(self) -> Columns:
        s = self.content
        return {"t": s.t, "torque": s.record.tau_m, "measured": s.measured, "simulated": s.simulated}

    def figure(self) -> Figure:
        s = self.content
        title = f"{s.record.name}: fit {fixed(s.fit_percent)} %"
        trace = downsampled(s.t, s.measured, s.simulated, s.unit)
        return draw_traces({title: trace}, s.output, on_axis(linear=s.unit.startswith("m")))
