"""A record with some of a model's parameters changed: the changes that its first part asks for, and what they leave of
its second. Each part has half of what is wrong, and may be one segment or many pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.refitted_model import RecordFit, RefittedModel, SegmentFit, carried, segment_fit
from robotid.diagnosis.refit.settings import REFIT
from robotid.diagnosis.scoring.record_change_candidate import RecordChangeCandidate, record_changes
from robotid.diagnosis.search.agreement import is_loud
from robotid.diagnosis.search.settings import CHANGES
from robotid.errors import NumericsError
from robotid.estimate.least_squares import Solution, SolveOptions, solve
from robotid.estimate.residual import Evaluation, OutputError
from robotid.estimate.sensing import joint_for
from robotid.estimate.separately import solve_by_pieces
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
    after: RecordFit

    def first(self, k: int) -> tuple[tuple[RecordChangeCandidate, ...], tuple[float, ...]]:
        """The first k changes, and their values."""
        return self.candidates[:k], self.values[:k]


@dataclass(frozen=True, slots=True, eq=False)
class Halves:
    """A record that is simulated clearly worse than those that a model was fitted to. first : its first part; before :
    what the model leaves of the second; usual : energy a sample that it leaves on the fitted segments. known : what was
    found with changes, by their names."""

    model: RefittedModel
    first: tuple[Segment, ...]
    before: RecordFit
    usual: float
    known: dict[tuple[str, ...], Changed | None] = field(default_factory=dict)

    @classmethod
    def of(cls, model: RefittedModel, seen: RecordFit, usual: float) -> Halves | None:
        """The halves of a record as it is simulated; None where its second one is simulated well, or not at all."""
        first, second = _parts(seen.segments)
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
        return record_changes(self.model.joint, self.model.columns, [self.first[0].record.name])

    @property
    def payload(self) -> tuple[RecordChangeCandidate, ...]:
        """Of these what a payload adds to, at the outermost place that carries one."""
        found = [one for one in self.candidates if one.parameter.carried]
        outermost = max(map(_place, found), key=[*Port].index, default=None)
        return tuple(one for one in found if _place(one) == outermost)

    def asks_for_more(self, after: RecordFit) -> bool:
        """Whether what is left of the second part is clearly worse than usual."""
        return is_loud(after.segments, self.usual, self.model.output)

    def beyond(self, after: RecordFit) -> float:
        """Energy of what is left, of the record or of a part of it, beyond the usual."""
        return after.energy - self.usual * after.samples

    def with_values(self, candidates: Sequence[RecordChangeCandidate], values: Sequence[float]) -> Changed | None:
        """The record with changes of these values; None where it diverges."""
        after = simulated(self.model, segments_of(self.before), candidates, values)
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
        found = each(_with_changes, shared, list(missing.values()), samples=sum(len(one.record) for one in self.first))
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


def segments_of(seen: RecordFit) -> tuple[Segment, ...]:
    """The segments of a record, to be simulated anew."""
    return tuple(Segment(one.record, one.whitening) for one in seen.segments)


def _parts(seen: Sequence[SegmentFit]) -> tuple[tuple[Segment, ...], tuple[Segment, ...]]:
    """A record in two parts, each with half the energy of its residual: the second tests what the first asks for, which
    no part does that rests or hardly shows it. None is shorter than a share of the whole; a piece of which one part
    would have hardly a sample stays as it is."""
    left = np.cumsum(np.concatenate([np.square(one.whitened) for one in seen]))
    shortest = max(round(CHANGES.shortest_part * len(left)), min(SHORTEST_PIECE, len(left) // 2))
    cut = int(np.clip(np.searchsorted(left, left[-1] / 2.0), shortest, len(left) - shortest))
    first, second = list[Segment](), list[Segment]()
    for one in seen:
        n, at = len(one.record), min(len(one.record), max(0, cut))
        least = min(SHORTEST_PIECE, n // 2)
        if at < least:
            at = 0
        elif n - at < least:
            at = n
        if at > 0:
            first.append(Segment(one.record.piece(0, at), one.whitening))
        if at < n:
            second.append(Segment(one.record.piece(at, n), one.whitening))
        cut -= n
    return tuple(first), tuple(second)


def _fitted_values(
    model: RefittedModel, segments: Sequence[Segment], candidates: Sequence[RecordChangeCandidate]
) -> tuple[float, ...] | None:
    """The changes that segments ask for, all other parameters fixed; None where they diverge. From none, and from what
    the plain squared error asks for, which noise that passes for slow errors hides where the record is far off."""
    plain = run(model, segments, candidates, whitened=False)
    starts = [None] if plain is None else [None, _values(plain, candidates)]
    found = [end for end in (run(model, segments, candidates, start=start) for start in starts) if end is not None]
    return _values(min(found, key=lambda end: end.cost), candidates) if found else None


def _values(end: Evaluation, candidates: Sequence[RecordChangeCandidate]) -> tuple[float, ...]:
    """The changes at the end of a fit."""
    return tuple(end.unknowns[: len(candidates)].tolist())


def simulated(
    model: RefittedModel,
    segments: Sequence[Segment],
    candidates: Sequence[RecordChangeCandidate] = (),
    values: Sequence[float] = (),
) -> RecordFit | None:
    """A record with all parameters fixed, its first states free; None where it diverges."""
    end = run(model, segments, candidates, values)
    return None if end is None else record_fit(model, segments, end)


def record_fit(model: RefittedModel, segments: Sequence[Segment], end: Evaluation) -> RecordFit:
    """What the end of a run leaves of a record."""
    pairs = zip(segments, end.trajectories, strict=True)
    return RecordFit(tuple(segment_fit(one, trajectory, model.output) for one, trajectory in pairs), model.output)


def run(
    model: RefittedModel,
    segments: Sequence[Segment],
    candidates: Sequence[RecordChangeCandidate] = (),
    values: Sequence[float] | None = None,
    *,
    start: Sequence[float] | None = None,
    whitened: bool = True,
) -> Evaluation | None:
    """A record with the parameters fixed but for changes, which are sought unless their values are given. start : of
    those that are sought; whitened : by the noise of the segments."""
    structure, names = model.structure, [one.name for one in candidates]
    for name in names:
        structure = structure.extended(name)
    parameters = carried(model.parameters, structure, dict(zip(names, values or start or (), strict=False)))
    sought = [values is None and name in names for name in parameters.names]
    records = tuple(one.record for one in segments)
    problem = OutputError(
        joint_for(structure, model.output, records),
        replace(parameters, free=np.array(sought)),
        records,
        model.output,
        np.ones(len(records)),
        bool(model.unknowns.first_states),
        tuple(one.whitening for one in segments) if whitened else (),
        REFIT.patience,
    )

    def solver(begun: Evaluation | None) -> Solution:
        unknowns = problem.start() if begun is None else begun.unknowns
        return solve(problem, unknowns, SolveOptions(CHANGES.max_iterations, REFIT.tolerance), initial=begun)

    try:
        return solve_by_pieces(problem, None, solver).evaluation
    except NumericsError:
        return None
