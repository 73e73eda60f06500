"""What the search knows at a time, and what it finds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.colour import ColouredNoise
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.nonparametric.curve_fit import FittedCurve
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.results import Confounded, Event
from robotid.diagnosis.scoring.ranking import CandidateScan, Round, rank, scan_candidates
from robotid.diagnosis.search.agreement import Agreement
from robotid.diagnosis.search.record_changes import RecordChange
from robotid.diagnosis.settings import VERDICT
from robotid.model.array import Array
from robotid.signals.record import Record

Log = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class AcceptedCause:
    """An effect that was accepted as a cause.

    explained : share of the first model's misfit that it removes from the fitted segments; gain : of the fit on the
    validation segments [% points]; twins : effects that these data cannot distinguish from it, itself first; before,
    after : the model without and with it; rival : the model with the first of its twins that was refitted; confounded :
    what answers much like it on these motions; beside : the cause without which it does not carry over, empty where it
    does by itself; unfollowed : as of the refit that it is; gain_p_value : of no gain on the validation segments,
    times the refits that were left of its round, which is cautious; one without any.
    """

    effect: str
    explained: float
    gain: float
    p_value: float
    twins: tuple[str, ...]
    before: RefittedModel
    after: RefittedModel
    rival: RefittedModel | None = None
    confounded: tuple[Confounded, ...] = ()
    beside: str = ""
    unfollowed: str | None = None
    gain_p_value: float = 1.0


@dataclass(frozen=True, slots=True)
class RejectedCause:
    """An effect that was refitted and rejected. explained and gain as of `AcceptedCause`; why : in words; imitates : it
    stands every test but that its parameters make sense, or (undriven) but that the motion moves it, so that something
    else acts like it; asked where no cause is found, of the first that does."""

    effect: str
    explained: float
    gain: float
    why: str
    imitates: bool = False
    undriven: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class SearchState:
    """What the search knows: every step takes a state and returns another.

    first : the model that is diagnosed; model : it with all causes so far; data : the records, with the noise as it
    shows behind `model`; scan : the columns of all candidates through `model`, whitened as `data` are; rounds : of the
    score so far, the last one of `scan` once it is scored; unexamined : candidates of a round for which no time was
    left; start : values from which the fit of the model that is diagnosed started, by parameter, where known; recorded
    : the records of the fit, whole where the model is fitted in pieces of them.
    """

    first: RefittedModel
    model: RefittedModel
    data: EvaluationData
    scan: CandidateScan
    causes: tuple[AcceptedCause, ...] = ()
    rejected: tuple[RejectedCause, ...] = ()
    rounds: tuple[Round, ...] = ()
    unexamined: tuple[str, ...] = ()
    start: Mapping[str, float] = field(default_factory=dict)
    recorded: tuple[Record, ...] = ()

    @property
    def round(self) -> Round:
        """The last round of the score."""
        return self.rounds[-1]

    @property
    def misfit(self) -> float:
        """Energy of the model's residuals beyond the noise, in variances of the noise."""
        return self.model.energy - self.data.samples

    def scored(self, criteria: Criteria) -> SearchState:
        """With one more round of the score."""
        return replace(self, rounds=(*self.rounds, rank(self.scan, criteria)))

    def with_model(self, model: RefittedModel, criteria: Criteria) -> SearchState:
        """With another model, and the candidates that it lacks."""
        return replace(self, model=model, scan=scan_candidates(model, criteria.skip))

    def with_cause(self, cause: AcceptedCause) -> SearchState:
        """With one cause more, which the model takes."""
        return replace(self, causes=(*self.causes, cause), model=cause.after)

    def with_rejected(self, *rejected: RejectedCause) -> SearchState:
        """With effects that were rejected."""
        return replace(self, rejected=(*self.rejected, *rejected))

    def share_removed(self, before: RefittedModel, after: RefittedModel) -> float:
        """Share of the first model's misfit energy, by the noise as it is here, that a step removes."""
        return share_removed(self.first, before, after, self.data)


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """What a search found.

    first, last : the model before and with all causes; data : the records, with the noise behind the last. curve : the
    free curve that explains most of what the causes leave, None where that is nothing; curve_share : of the first
    model's misfit that it explains; beside_curve : the causes were found beside it. changes : what differs on
    validation records. unexamined : what no time was left for, candidates by name, then the rest in words; late :
    whether the time was up before the end. events : what happened once; all else is of records without them.
    noise, coloured : noise of any colour, as the last model leaves it, and the data by it; None where time ran out
    before.
    agreement : whether the last model can be that of the validation records, too, sought where nothing else was
    found. shares_of_removed : the causes leave nothing but noise, and its energy is no measure of the misfit, which was
    no more than chance makes of it, or of which it explains all by simulations only: shares are of what they remove.
    """

    data: EvaluationData
    first: RefittedModel
    last: RefittedModel
    causes: tuple[AcceptedCause, ...]
    rejected: tuple[RejectedCause, ...]
    rounds: tuple[Round, ...]
    curve: FittedCurve | None = None
    curve_share: float = 0.0
    beside_curve: bool = False
    changes: tuple[RecordChange, ...] = ()
    unexamined: tuple[str, ...] = ()
    late: bool = False
    events: tuple[Event, ...] = ()
    noise: ColouredNoise | None = None
    coloured: EvaluationData | None = None
    agreement: Agreement = field(default_factory=Agreement)
    shares_of_removed: bool = False

    @property
    def remaining_share(self) -> float:
        """Share of the first model's misfit energy that the causes leave."""
        return max(0.0, 1.0 - sum(cause.explained for cause in self.causes))

    @property
    def imitated(self) -> bool:
        """Whether no cause was found, and something that is no noise acts like an effect that makes no sense."""
        return not self.causes and any(one.imitates for one in self.rejected)

    @property
    def shaken_share(self) -> float:
        """Share of the misfit that rings by itself, zero where that is not so."""
        return next((one.explained for one in self.rejected if one.undriven), 0.0) if self.imitated else 0.0

    def without_causes(self, whys: Sequence[str]) -> SearchResult:
        """With its causes rejected, as of the model without them. whys : in words, of each."""
        rejected = [RejectedCause(c.effect, c.explained, c.gain, why) for c, why in zip(self.causes, whys, strict=True)]
        return replace(self, last=self.first, causes=(), rejected=(*rejected, *self.rejected))

    @property
    def judging(self) -> EvaluationData:
        """The data by whose noise shares are measured: by noise of any colour where that is all that is left."""
        return self.coloured if self.coloured is not None and self.coloured.noise_reached else self.data

    def explained_by_record(self) -> dict[str, float]:
        """Share of the first model's misfit energy that all causes remove, of each record, by the noise that shows at
        last, or plainly as of `is_plain`; where shares are of what causes remove, all or nothing."""
        data = self.judging
        segments = (*data.fitted, *data.validation)
        before, after = (*self.first.fitted, *self.first.validation), (*self.last.fitted, *self.last.validation)
        misfit = Segment.energy if self.shares_of_removed else _measure(plain=is_plain(self.first, data))
        whole, removed = dict[str, float](), dict[str, float]()
        for segment, one, other in zip(segments, before, after, strict=True):
            name, energy = segment.record.name, misfit(segment, one.residual)
            whole[name] = whole.get(name, 0.0) + energy
            removed[name] = removed.get(name, 0.0) + energy - misfit(segment, other.residual)
        if self.shares_of_removed:
            return {name: float(energy > 0.0) for name, energy in removed.items()}
        return {name: float(np.clip(removed[name] / max(whole[name], 1e-9), 0.0, 1.0)) for name in whole}


def misfit_energy(model: RefittedModel, data: EvaluationData) -> float:
    """Energy of a model's residuals beyond the noise, by the noise as it is in these data."""
    return data.fitted_energy(model.fitted) - data.samples


def is_covered(first: RefittedModel, data: EvaluationData) -> bool:
    """Whether the noise of these data, which then counts what a model lacks as errors of the torque, leaves nothing of
    the first model's misfit."""
    return misfit_energy(first, data) <= VERDICT.chance * float(np.sqrt(2.0 * data.samples))


def is_plain(first: RefittedModel, data: EvaluationData) -> bool:
    """Whether shares are of the plain squared error: where all that nothing known explains counts as errors of the
    torque, what is beyond that noise may be a hundredth of what is wrong; unless it has been seen to be all noise."""
    return (data.torque_errors is not None and not data.noise_reached) or is_covered(first, data)


def share_removed(
    first: RefittedModel,
    before: RefittedModel,
    after: RefittedModel,
    data: EvaluationData,
    *,
    plain: bool | None = None,
) -> float:
    """Share of the first model's misfit that a step removes from the fitted segments.

    plain : True compares squared errors, False whitened energy beyond the noise of these data. None chooses: whitened
    energy beyond the noise; where the noise covers the misfit, the squared error or, beside coloured errors of the
    torque, whose own squared error that mostly is, all whitened energy.
    """
    covered = is_covered(first, data) if plain is None else plain
    coloured = plain is None and covered and data.torque_errors == "coloured"
    misfit = Segment.energy if coloured else _measure(plain=covered)
    whole, left, then = (
        sum(misfit(segment, one.residual) for segment, one in zip(data.fitted, model.fitted, strict=True))
        for model in (first, before, after)
    )
    return float(np.clip((left - then) / max(whole, 1e-300), 0.0, 1.0))


def share_of_removed(first: RefittedModel, model: RefittedModel, last: RefittedModel, data: EvaluationData) -> float:
    """Share that a model removes of what the last one removes of the first one's energy on the fitted segments."""
    energy, then, least = (data.fitted_energy(one.fitted) for one in (first, model, last))
    return float(np.clip((energy - then) / max(energy - least, 1e-300), 0.0, 1.0))


def _measure(*, plain: bool) -> Callable[[Segment, Array], float]:
    """By what the misfit of a residual (n,) on a segment is measured."""
    return _plain_misfit if plain else _misfit_beyond_noise


def _plain_misfit(segment: Segment, residual: Array) -> float:
    return float(residual @ residual)


def _misfit_beyond_noise(segment: Segment, residual: Array) -> float:
    return segment.energy(residual) - len(residual)
