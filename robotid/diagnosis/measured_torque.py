"""Whether a model bears the recorded torque out along the measured motion.

A simulated output can come near a recorded one for the wrong reason, as where a column is not what it was taken for.
The measured motion does not depend on the simulation: inverse dynamics along it give the torque that a model asks for.
A model that misses the recorded torque by more than the whole of it is worse than one without any torque.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from robotid.catalogue import EFFECTS, assemble
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refitted_model import carried
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.diagnosis.search.agreement import Agreement
from robotid.diagnosis.search.state import SearchResult
from robotid.diagnosis.settings import VERDICT
from robotid.errors import NumericsError
from robotid.estimate.cutoff import choose_cutoff
from robotid.estimate.fitted_model import FittedModel
from robotid.estimate.regressor import friction_power
from robotid.estimate.rigid import fit_rigid, torque_error
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.numerals import plain
from robotid.signals.differentiate import ParallelFilter
from robotid.signals.record import Record

NONE_AT_ALL = 1.0  # relative error of a model without any torque
CONTRADICTED = (
    "along the measured motion the model asks for another torque than was recorded, and none that is physical comes"
    " near: `robotid check` examines signs and columns"
)


def contradicts(model: FittedModel, found: MeasuredTorque | None, criteria: Criteria) -> bool:
    """Whether a model errs by more than the recorded torque, and whether with any one effect of the catalogue nothing
    physical explains that torque along the measured motion, so that there is nothing to extend.

    found : of the records of its fit, None where none tells of a rigid motion.
    """
    if found is None or found.error(model.joint, model.parameters) < NONE_AT_ALL:
        return False
    least = float(np.sqrt(1.0 - VERDICT.min_explained))
    return all(error > least for error in found.physical_errors(model, criteria))


def without_contradicted(result: SearchResult, known: MeasuredTorque | None = None) -> SearchResult:
    """The result with its causes rejected where the model with them errs by more than the recorded torque, and the
    regression of that torque on the model without them does not.

    known : of the records of the fit as they were before the search, which may have changed them.
    """
    if not result.causes:
        return result
    records = [one.record for one in result.last.fitted]
    records = records if known is None else known.whole(records)
    first, last = result.first, result.last
    unchanged = known is not None and known.is_of(records)
    found = known if unchanged else MeasuredTorque.of(first.joint, first.parameters, records)
    if found is None:
        return result
    error, regressed = found.error(last.joint, last.parameters), found.regressed(first.joint, first.parameters)
    if error < NONE_AT_ALL or regressed >= NONE_AT_ALL:
        return result
    why = (
        f"contradicts the recorded torque: along the measured motion the model with it errs by {plain(100 * error)} %"
        f" of that, and a regression without it by {plain(100 * regressed)} %"
    )
    without = result.without_causes([why] * len(result.causes))
    return replace(without, changes=(), noise=None, coloured=None, agreement=Agreement())


@dataclass(frozen=True, slots=True)
class MeasuredTorque:
    """The records among `given` whose torque tells of a rigid motion, and the filter through which it does."""

    given: tuple[Record, ...]
    records: tuple[Record, ...]
    parallel: ParallelFilter

    @classmethod
    def of(cls, joint: Joint, parameters: Parameters, records: Sequence[Record]) -> MeasuredTorque | None:
        """None where none of them does."""
        found, cutoffs = list[Record](), list[float]()
        for k, record in enumerate(records):
            with suppress(NumericsError):
                cutoffs.append(choose_cutoff(joint, parameters, record))
                found.append(replace(record, name=f"{k}"))  # of pieces each its own
        return cls(tuple(records), tuple(found), ParallelFilter(min(cutoffs))) if found else None

    def is_of(self, records: Sequence[Record]) -> bool:
        """Whether it is of these records, or of copies of them as other processes hand them back."""
        return len(records) == len(self.given) and all(map(_is_same, records, self.given))

    def whole(self, records: Sequence[Record]) -> list[Record]:
        """The given records with the torque of pieces of theirs, which are too short for the filter of a slow motion;
        the records themselves where they are not all of these."""
        found = []
        for given in self.given:
            end = given.begin + given.duration - given.sampling_time / 2
            own = [one for one in records if one.name == given.name and given.begin <= one.begin < end]
            if sum(map(len, own)) != len(given):
                return list(records)
            torque = np.concatenate([one.tau_m for one in own])
            found.append(own[0] if len(own) == 1 else replace(given, tau_m=torque))
        return found

    def error(self, joint: Joint, parameters: Parameters) -> float:
        """Of inverse dynamics, relative to the recorded torque: root mean square over the records."""
        errors = [torque_error(joint, parameters, record, self.parallel) for record in self.records]
        return float(np.sqrt(np.mean(np.square(errors)))) / 100.0

    def regressed(self, joint: Joint, parameters: Parameters) -> float:
        """The same of the regression within bounds; that of no torque at all where the records do not determine it, or
        where friction would have to drive the joint."""
        try:
            guesses = fit_rigid(joint, parameters, self.records, self.parallel).guesses
        except NumericsError:
            return NONE_AT_ALL
        found = parameters.with_values(guesses)
        power = sum(friction_power(joint, found, record, self.parallel) for record in self.records)
        return self.error(joint, found) if power >= 0.0 else NONE_AT_ALL

    def physical_errors(self, model: FittedModel, criteria: Criteria) -> Iterator[float]:
        """Of the regression of the model, and of it with every candidate besides."""
        structure = model.joint.structure
        yield self.regressed(model.joint, model.parameters)
        for one in candidates(structure, model.output, criteria.skip, self.records):
            if one.name.partition(".")[2] in EFFECTS:
                extended = structure.extended(one.name)
                start = carried(model.parameters, extended, one.start([0.0] * len(one.scored)))
                yield self.regressed(assemble(extended), start)


def _is_same(one: Record, other: Record) -> bool:
    """Whether two records are of the same torque along the same motion."""
    if one is other:
        return True
    times = (one.name, one.begin, one.sampling_time) == (other.name, other.begin, other.sampling_time)
    signals = ((one.tau_m, other.tau_m), (one.phi_m, other.phi_m), (one.dphi_m, other.dphi_m))
    return times and all(np.array_equal(*pair) for pair in signals)
