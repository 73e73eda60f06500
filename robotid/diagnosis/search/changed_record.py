"""A record with some of a model's parameters changed: the changes that its first part asks for, and what they leave of
its second. Each part has half of what is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, carried, segment_fit
from robotid.diagnosis.refit.settings import REFIT
from robotid.diagnosis.scoring.record_change_candidate import RecordChangeCandidate, record_changes
from robotid.diagnosis.search.agreement import is_loud
from robotid.diagnosis.search.settings import CHANGES
from robotid.errors import NumericsError
from robotid.estimate.least_squares import SolveOptions, solve
from robotid.estimate.residual import Evaluation, OutputError
from robotid.estimate.sensing import joint_for
from robotid.model.array import Array
from robotid.model.port import Port
from robotid.model.structure import changed
from robotid.parallel import each
from robotid.signals.record import SHORTEST_PIECE


@dataclass(frozen=True, slots=True, eq=False)
class Changed:
    """A record with changes, found on its first part. values : theirs; after : what the model simulates of the second
    part with them."""

    candidates: tuple[RecordChangeCandidate, ...]
    values: tuple[float, ...]
    after: SegmentFit

    def first(self, k: int) -> tuple[tuple[RecordChangeCandidate, ...], tuple[float, ...]]:
        """The first k changes, and their values."""
        return self.candidates[:k], self.values[:k]


@dataclass(frozen=True, slots=True, eq=False)
class Halves:
    """A record that is simulated clearly worse than those that a model was fitted to. first : its first part; before :
    what the model leaves of the second; usual : energy a sample that it leaves on the fitted segments. known : what was
    found with changes, by their names."""

    model: RefittedModel
    first: Segment
    before: SegmentFit
    usual: float
    known: dict[tuple[str, ...], Changed | None] = field(default_factory=dict)

    @classmethod
    def of(cls, model: RefittedModel, segment: Segment, residual: Array, usual: float) -> Halves | None:
        """The halves of a segment by its residual (n,); None where its second one is simulated well, or not at all."""
        first, second = _parts(segment, residual)
        before = simulated(model, second)
        found = None if before is None else cls(model, first, before, usual)
        return found if found is not None and found.asks_for_more(found.before) else None

    @property
    def unchanged(self) -> Changed:
        """The record without any change."""
        return Changed((), (), self.before)

    @property
    def candidates(self) -> tuple[RecordChangeCandidate, ...]:
        """Every parameter that may differ on the record."""
        return record_changes(self.model.joint, self.model.columns, [self.first.record.name])

    @property
    def payload(self) -> tuple[RecordChangeCandidate, ...]:
        """Of these what a payload adds to, at the outermost place that carries one."""
        found = [one for one in self.candidates if one.parameter.carried]
        outermost = max(map(_place, found), key=[*Port].index, default=None)
        return tuple(one for one in found if _place(one) == outermost)

    def asks_for_more(self, after: SegmentFit) -> bool:
        """Whether what is left of the second part is clearly worse than usual."""
        return is_loud([after], self.usual, self.model.output)

    def beyond(self, after: SegmentFit) -> float:
        """Energy of what is left of the second part beyond the usual."""
        return after.energy - self.usual * len(after.residual)

    def with_values(self, candidates: Sequence[RecordChangeCandidate], values: Sequence[float]) -> Changed | None:
        """The record with changes of these values; None where it diverges."""
        second = Segment(self.before.record, self.before.whitening)
        after = simulated(self.model, second, candidates, values)
        return None if after is None else Changed(tuple(candidates), tuple(values), after)

    def with_changes(self, candidates: Sequence[RecordChangeCandidate]) -> Changed | None:
        """The record with the changes that its first part asks for, all at once; None where it diverges."""
        (found,) = self._each_with_changes([tuple(candidates)])
        return found

    def with_one_more(self, at: Changed, candidates: Sequence[RecordChangeCandidate]) -> list[Changed]:
        """The record with one change more of the candidates each, the one that carries over best first."""
        found = self._each_with_changes([(*at.candidates, one) for one in candidates if one not in at.candidates])
        return sorted((one for one in found if one is not None), key=lambda one: one.after.energy)

    def _each_with_changes(self, sets: Sequence[tuple[RecordChangeCandidate, ...]]) -> list[Changed | None]:
        """The record with each set of changes, as of `with_changes`."""
        names = [tuple(one.name for one in candidates) for candidates in sets]
        missing = {key: candidates for key, candidates in zip(names, sets, strict=True) if key not in self.known}
        shared = replace(self, model=replace(self.model, fitted=(), validation=()), known={})
        found = each(_with_changes, shared, list(missing.values()), samples=len(self.first.record))
        self.known.update(zip(missing, found, strict=True))
        return [self.known[key] for key in names]

    def with_all(self, candidates: Sequence[RecordChangeCandidate]) -> Changed | None:
        """The record with changes that belong together, found all at once or one beside the other, whichever carries
        over better; None where it diverges."""
        at: Changed | None = self.unchanged
        while at is not None and len(at.values) < len(candidates):
            at = next(iter(self.with_one_more(at, candidates)), None)
        ends = [one for one in (at, self.with_changes(candidates)) if one is not None]
        return min(ends, key=lambda one: one.after.energy, default=None)


def _with_changes(halves: Halves, candidates: tuple[RecordChangeCandidate, ...]) -> Changed | None:
    """The record with the changes that its first part asks for; None where it diverges."""
    values = _fitted_values(halves.model, halves.first, candidates)
    return None if values is None else halves.with_values(candidates, values)


def _place(candidate: RecordChangeCandidate) -> Port:
    return Port(changed(candidate.name)[1].partition(".")[0])


def _parts(segment: Segment, residual: Array) -> tuple[Segment, Segment]:
    """A segment in two, each with half the energy of its residual (n,): the second tests what the first asks for, which
    no part does that rests or hardly shows it. None is shorter than a share of the whole."""
    record, left = segment.record, np.cumsum(np.square(segment.whitening(residual)))
    shortest = max(round(CHANGES.shortest_part * len(record)), min(SHORTEST_PIECE, len(record) // 2))
    cut = int(np.clip(np.searchsorted(left, left[-1] / 2.0), shortest, len(record) - shortest))
    return replace(segment, record=record.piece(0, cut)), replace(segment, record=record.piece(cut, len(record)))


def _fitted_values(
    model: RefittedModel, segment: Segment, candidates: Sequence[RecordChangeCandidate]
) -> tuple[float, ...] | None:
    """The changes that a segment asks for, all other parameters fixed; None where it diverges. From none, and from what
    the plain squared error asks for, which noise that passes for slow errors hides where the segment is far off."""
    plain = run(model, segment, candidates, whitened=False)
    starts = [None] if plain is None else [None, _values(plain, candidates)]
    found = [end for end in (run(model, segment, candidates, start=start) for start in starts) if end is not None]
    return _values(min(found, key=lambda end: end.cost), candidates) if found else None


def _values(end: Evaluation, candidates: Sequence[RecordChangeCandidate]) -> tuple[float, ...]:
    """The changes at the end of a fit."""
    return tuple(end.unknowns[: len(candidates)].tolist())


def simulated(
    model: RefittedModel,
    segment: Segment,
    candidates: Sequence[RecordChangeCandidate] = (),
    values: Sequence[float] = (),
) -> SegmentFit | None:
    """A segment with all parameters fixed, its first states free; None where it diverges."""
    end = run(model, segment, candidates, values)
    return None if end is None else segment_fit(segment, end.trajectories[0], model.output)


def run(
    model: RefittedModel,
    segment: Segment,
    candidates: Sequence[RecordChangeCandidate] = (),
    values: Sequence[float] | None = None,
    *,
    start: Sequence[float] | None = None,
    whitened: bool = True,
) -> Evaluation | None:
    """A segment with the parameters fixed but for changes, which are sought unless their values are given. start : of
    those that are sought; whitened : by the noise of the segment."""
    structure, names = model.structure, [one.name for one in candidates]
    for name in names:
        structure = structure.extended(name)
    parameters = carried(model.parameters, structure, dict(zip(names, values or start or (), strict=False)))
    sought = [values is None and name in names for name in parameters.names]
    problem = OutputError(
        joint_for(structure, model.output, (segment.record,)),
        replace(parameters, free=np.array(sought)),
        (segment.record,),
        model.output,
        np.ones(1),
        bool(model.unknowns.first_states),
        (segment.whitening,) if whitened else (),
        REFIT.patience,
    )
    try:
        return solve(problem, problem.start(), SolveOptions(CHANGES.max_iterations, REFIT.tolerance)).evaluation
    except NumericsError:
        return None
