"""Growing a model: score what could be missing, refit the best few, keep what pays on records held out, and repeat."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.residual import OutputError, observed
from robotid.judge.candidates import Candidate, Difference, candidates, differences
from robotid.judge.changes import Change, changes
from robotid.judge.noise import estimate_noise
from robotid.judge.score import (
    DEPENDENT,
    Projected,
    Scan,
    Score,
    project,
    scan,
    score,
    significance,
    unexplained,
)
from robotid.judge.simulated import Model, measured, simulate_record
from robotid.judge.trial import Bench, Trial, extended, first_state, try_model
from robotid.judge.unknown import Shape, free_forces, shapes
from robotid.judge.whitening import Whitening, whitening
from robotid.model.array import Array
from robotid.model.structure import RECORD_CHANGE
from robotid.signals.record import Record

SAME = 0.02  # of the energy explained: causes closer than that are not told apart
SAME_FLOOR = 12.0  # of noise variances, inflated: as far apart as chance sets two equal models
NOTHING = 0.1  # of the misfit: a curve that explains less of it is no news
IMITATES = 0.7  # of what a free curve explains: causes that do not reach it only imitate something else
IMITATES_NOISE = 0.97  # the same where a model could reach the noise
TRUSTED = 2  # causes that are added before the question is asked whether they only imitate
MOST_ALIKE = 0.1  # of the energy explained, however much chance there is
RIVAL = 0.9  # of the best score: candidates below it are not tried against one that explains nearly all
HOPEFUL = 0.5  # of the best score: candidates below it are not refitted
COLLINEAR = 0.999  # cosine at which columns are the same

Log = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Terms:
    """On what terms a cause is accepted. level : of significance of a whole search; worth : least RMS misfit that it
    must remove on held-out records, in noise standard deviations; refits : effects refitted a round; causes : most of
    them; skip : effects that are out of the question."""

    level: float = 1e-3
    worth: float = 0.1
    refits: int = 5
    causes: int = 4
    skip: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """A cause that was accepted. explained : share of the first model's misfit that it removes from the fitted records;
    gain : of held-out fit in % points; twins : effects, itself first; before, after : the trials; rival : of the first
    twin."""

    effect: str
    explained: float
    gain: float
    p_value: float
    twins: tuple[str, ...]
    before: Trial
    after: Trial
    rival: Trial | None = None


@dataclass(frozen=True, slots=True)
class Turned:
    """An effect that was turned down."""

    effect: str
    explained: float
    gain: float
    why: str


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """One look at a model. inflation : energy of the residual per direction that no single candidate explains."""

    scans: tuple[Scan, ...]
    projected: Projected
    scores: tuple[Score, ...]
    inflation: float


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """What a search found. first, last : the model before and with all causes; bench : the last, and what noise is
    there. shape : the curve that explains most of what the causes leave, None where that is nothing; share : of the
    first model's misfit. changes : what differs on records held out."""

    bench: Bench
    first: Trial
    last: Trial
    causes: tuple[Found, ...]
    turned: tuple[Turned, ...]
    rounds: tuple[Round, ...]
    shape: Shape | None = None
    share: float = 0.0
    changes: tuple[Change, ...] = ()


def search(
    model: Model, fitted: Sequence[Record], held: Sequence[Record], horizon: float | None, terms: Terms, log: Log
) -> Growth:
    """What a model lacks, by the noise of the sensors; and where that is out of reach and names nothing, as it is on
    most machines, by that of torque errors besides."""
    log("measuring the noise")
    bench, first = set_up(model, fitted, held, horizon, terms)
    growth = grow(first, bench, terms, log)
    if growth.causes or bench.reached:
        return growth
    log("allowing for errors of the torque")
    bench, first = set_up(model, fitted, held, horizon, terms, errors=True)
    blunt = grow(first, bench, terms, log)
    return blunt if blunt.causes or growth.shape is None else growth


def set_up(
    model: Model,
    fitted: Sequence[Record],
    held: Sequence[Record],
    horizon: float | None,
    terms: Terms,
    *,
    errors: bool = False,
) -> tuple[Bench, Trial]:
    """The bench for a fitted model, its noise found in the residuals, and the model refitted on it."""
    runs = [simulate_record(model, record, horizon) for record in fitted]
    pieces = [piece for run in runs for piece in run.pieces]
    trajectories = [t for run in runs for t in run.trajectories]
    bare = OutputError(
        model.joint, model.parameters, tuple(pieces), model.output, np.ones(len(pieces)), model.estimate_states
    )
    missing = candidates(model.joint.structure, model.output, terms.skip)
    scans = []
    for piece, t in zip(pieces, trajectories, strict=True):
        residual = measured(piece, model.output) - observed(t, model.output)
        scans.append(scan(t, piece, residual, model.output, bare.columns, bare.free_states, missing))
    whiten, reached = estimate_noise(scans, model.output, bare.row, lambda: _freed(scans, bare), errors=errors)
    held_pieces = tuple(piece for record in held for piece in record.pieces(horizon or record.duration))
    whiten_held = _held_whitening(bare, model.theta, whiten, held_pieces)
    bench = Bench(tuple(pieces), held_pieces, whiten, whiten_held, model.output, model.estimate_states, reached, errors)
    states = [first_state(t) for t in trajectories]
    return bench, try_model(model.joint.structure, model.parameters, bench, states)


def look(trial: Trial, bench: Bench, terms: Terms) -> tuple[Scan, ...]:
    """Every record of the fit with all columns of all candidates."""
    missing = candidates(trial.structure, bench.output, terms.skip)
    p = trial.problem
    return tuple(
        scan(t, record, residual, bench.output, p.columns, p.free_states, missing)
        for t, record, residual in zip(trial.trajectories, bench.fitted, trial.residuals, strict=True)
    )


def rank(trial: Trial, scans: Sequence[Scan], bench: Bench, terms: Terms) -> Round:
    """All candidates by what they would explain, and every parameter as different in each record."""
    names = list(dict.fromkeys(record.name for record in bench.fitted))
    wanted = len(names) > 1 and RECORD_CHANGE not in terms.skip
    other = differences(trial.problem.joint, trial.problem.columns, names) if wanted else ()
    missing = (*candidates(trial.structure, bench.output, terms.skip), *other)
    columns = trial.problem.columns
    projected = project([_with_differences(one, other, columns) for one in scans], bench.whiten)
    scores = score(projected, missing)
    best = best_of_each(scores)
    return Round(tuple(scans), projected, tuple(scores), _inflation(projected, best))


def _with_differences(one: Scan, other: Sequence[Candidate], columns: Sequence[int]) -> Scan:
    """A record with the columns of parameters that differ in it, or do not."""
    if not other:
        return one
    more = np.zeros((len(other), len(one.record)))
    for i, candidate in enumerate(other):
        difference = candidate.effect
        if isinstance(difference, Difference) and difference.record == one.record.name:
            more[i] = one.signals[one.states + list(columns).index(difference.column)]
    return replace(one, signals=np.concatenate([one.signals[:-1], more, one.signals[-1:]]))


def _inflation(projected: Projected, best: Sequence[Score]) -> float:
    """Mean energy of the residual along the directions that candidates reach and the best of them does not."""
    u, values, _ = np.linalg.svd(projected.missing / np.where(projected.length > 0, projected.length, 1.0))
    reached = u[:, : int(np.sum(values > DEPENDENT * values[0]))].T @ projected.residual
    taken, k = (best[0].energy, len(best[0].amplitude)) if best else (0.0, 0)
    return max(1.0, (float(reached @ reached) - taken) / max(1, len(reached) - k))


def best_of_each(scores: Sequence[Score]) -> list[Score]:
    """The best point of each effect's grid, best first."""
    found: dict[str, Score] = {}
    for one in scores:
        if one.energy > 0:
            found.setdefault(one.candidate.name, one)
    return list(found.values())


def p_value(one: Score, seen: Round, bench: Bench) -> float:
    """Of the best of all candidates; the residual that other candidates could explain counts as its noise."""
    tries, k = len(seen.scores), len(one.amplitude)
    white = significance(one.energy, k, seen.projected.energy, bench.samples, tries)
    coloured = significance(one.energy, k, one.energy + seen.inflation * len(seen.scores), len(seen.scores), tries)
    return max(white, coloured)


def grow(first: Trial, bench: Bench, terms: Terms, log: Log) -> Growth:
    """Extend a model cause by cause."""
    now, causes, turned, rounds = first, list[Found](), list[Turned](), list[Round]()
    while len(causes) < terms.causes:
        log(f"scoring the catalogue for cause {len(causes) + 1}")
        seen = rank(now, look(now, bench, terms), bench, terms)
        rounds.append(seen)
        found = _accept(first, now, seen, bench, terms, turned, log)
        if found is None:
            break
        causes.append(found)
        bench, now = renew(found.after, bench, terms)
        if len(causes) == TRUSTED and _imitated(first, now, bench) is not None:
            break
    log("looking for what no effect explains")
    growth = Growth(bench, first, now, tuple(causes), tuple(turned), tuple(rounds))
    imitated = _imitated(first, now, bench) if causes else None
    growth = _with_unknown(growth, terms) if imitated is None else _as_unknown(growth, imitated)
    if RECORD_CHANGE in terms.skip:
        return growth
    log("comparing the records held out")
    return replace(growth, changes=changes(growth.last, bench))


def _with_unknown(growth: Growth, terms: Terms) -> Growth:
    """The search with the curve that explains most of what it leaves, where that is worth a word."""
    bench, whole = growth.bench, misfit_energy(growth.first, growth.bench)
    if growth.last.energy - bench.samples < terms.worth**2 * bench.samples or whole <= 0.0:
        return growth
    left = shapes(growth.last, bench)
    if not left or not _curve_stands(left[0], growth, terms) or left[0].energy < NOTHING * whole:
        return growth
    return replace(growth, shape=left[0], share=min(1.0, left[0].energy / whole))


def _imitated(first: Trial, last: Trial, bench: Bench) -> Shape | None:
    """The free curve that explains clearly more of the first model's misfit than all causes do, or None."""
    least = IMITATES_NOISE if bench.reached else IMITATES
    whole = misfit_energy(first, bench)
    explained = whole - (last.energy - bench.samples)
    if explained > least * whole:
        return None
    free = next(iter(shapes(first, bench)), None)
    return None if free is None or explained > least * free.energy else free


def _as_unknown(growth: Growth, shape: Shape) -> Growth:
    """The search with its causes turned down for a curve."""
    share = min(1.0, shape.energy / max(misfit_energy(growth.first, growth.bench), 1e-9))
    why = f"only imitates: a free curve along {shape.curve.along} explains {100 * share:.0f} % of the misfit"
    imitations = [Turned(c.effect, c.explained, c.gain, why) for c in growth.causes]
    turned = (*imitations, *growth.turned)
    return replace(growth, last=growth.first, causes=(), turned=turned, shape=shape, share=share)


def _curve_stands(shape: Shape, growth: Growth, terms: Terms) -> bool:
    bench = growth.bench
    tries = len(growth.rounds[-1].scores)
    p = significance(shape.energy, shape.knots, growth.last.energy, bench.samples, tries)
    return p < terms.level and shape.energy > terms.worth**2 * bench.samples


def misfit_energy(first: Trial, bench: Bench) -> float:
    """Energy of a model's residuals beyond the noise, as a bench sees them."""
    whitened = (w(r) for w, r in zip(bench.whiten, first.residuals, strict=True))
    return sum(float(np.sum(r**2)) for r in whitened) - bench.samples


def renew(trial: Trial, bench: Bench, terms: Terms) -> tuple[Bench, Trial]:
    """The bench with the noise as it shows behind a better model, never larger, and that model refitted on it."""
    problem, theta = trial.problem, trial.parameters.values
    scans = look(trial, bench, terms)
    whiten, _ = estimate_noise(scans, bench.output, problem.row, lambda: _freed(scans, problem), errors=bench.errors)
    if max(w.torque for w in whiten) > max(w.torque for w in bench.whiten):
        return bench, trial
    held = _held_whitening(problem, theta, whiten, bench.held)
    bench = replace(bench, whiten=whiten, whiten_held=held)
    return bench, try_model(trial.structure, trial.parameters, bench, trial.first_states)


def _freed(scans: Sequence[Scan], problem: OutputError) -> list[Array]:
    """What of each residual neither candidates nor free curves explain, (n,) each."""
    found = []
    for one in scans:
        t, more = one.trajectory, free_forces(one.trajectory)
        curves = scan(t, one.record, one.residual, problem.output, problem.columns, problem.free_states, (), more)
        found.append(unexplained(replace(curves, signals=np.concatenate([one.signals[:-1], curves.signals]))))
    return found


def _held_whitening(
    problem: OutputError, theta: Array, whiten: Sequence[Whitening], held: Sequence[Record]
) -> tuple[Whitening, ...]:
    """Records that were held out have the typical noise of the others."""
    typical = (float(np.median([w.output for w in whiten])), float(np.median([w.torque for w in whiten])))
    return tuple(whitening(problem.joint, theta, problem.row, record.sampling_time, typical) for record in held)


def _accept(
    first: Trial, now: Trial, seen: Round, bench: Bench, terms: Terms, turned: list[Turned], log: Log
) -> Found | None:
    """The best cause of a round that stands all tests, or None."""
    hopeful = [s for s in best_of_each(seen.scores) if p_value(s, seen, bench) < terms.level]
    hopeful = [s for s in hopeful if s.energy > max(HOPEFUL * hopeful[0].energy, terms.worth**2 * bench.samples)]
    tried = sorted(_refit(now, hopeful[: terms.refits], bench, log), key=lambda pair: _criterion(pair[1], bench))
    while tried:
        best, after = tried[0]
        why = _objection(now, after, bench, terms)
        if why is None:
            return _found(first, now, tried, best, after, seen, bench)
        turned.append(
            Turned(
                best.candidate.name,
                _share(first, now, after, bench),
                after.held_fit_percent - now.held_fit_percent,
                why,
            )
        )
        tried = tried[1:]
    return None


def _refit(now: Trial, hopeful: Sequence[Score], bench: Bench, log: Log) -> Iterator[tuple[Score, Trial]]:
    """Refits in the order of the scores; once one explains nearly all, only what scores nearly as well is tried."""
    reached = False
    for one in hopeful:
        if reached and one.energy < RIVAL * hopeful[0].energy:
            continue
        log(f"refitting with {one.candidate.name}")
        try:
            after = refit(now, one, bench)
        except NumericsError:
            continue
        reached = reached or now.energy - after.energy > IMITATES_NOISE * (now.energy - bench.samples)
        yield one, after


def _criterion(trial: Trial, bench: Bench) -> float:
    """Bayesian information criterion, up to a constant, of a residual whose variance is unknown."""
    return bench.samples * float(np.log(trial.energy)) + len(trial.problem.columns) * float(np.log(bench.samples))


def refit(now: Trial, one: Score, bench: Bench) -> Trial:
    """The model with a candidate, from the amplitude that its score promises."""
    c = one.candidate
    values = dict(zip((p.symbol for p in c.effect.parameters), c.values, strict=True))
    values |= dict(zip((c.effect.parameters[k].symbol for k in c.scored), one.amplitude, strict=True))
    named = {f"{c.name}.{s}": v for s, v in values.items()}
    if isinstance(c.effect, Difference):
        named = {c.name: one.amplitude[0]}
    return try_model(*extended(now, c.name, named), bench, now.first_states)


def _objection(now: Trial, after: Trial, bench: Bench, terms: Terms) -> str | None:
    """Why a refitted cause is none, in words; None where it stands."""
    if bench.held:
        gained = now.held_energy - after.held_energy
        samples = sum(map(len, bench.held))
        if gained <= 0:
            return "does not carry over: the held-out records are simulated worse with it"
        if after.held_fit_percent <= now.held_fit_percent:
            return "does not carry over: the fit of the held-out records falls with it"
    else:
        gained, samples = now.energy - after.energy, bench.samples
    if gained < terms.worth**2 * samples:
        return f"is not worth it: removes {np.sqrt(max(0.0, gained) / samples):.2g} noise standard deviations"
    return None


def _share(first: Trial, now: Trial, after: Trial, bench: Bench) -> float:
    """Share of the first model's misfit energy, as this bench sees it, that a step removes."""
    return float(np.clip((now.energy - after.energy) / max(misfit_energy(first, bench), 1e-9), 0.0, 1.0))


def _found(
    first: Trial, now: Trial, tried: Sequence[tuple[Score, Trial]], best: Score, after: Trial, seen: Round, bench: Bench
) -> Found:
    explained = now.energy - after.energy
    slack = max(SAME * explained, min(SAME_FLOOR * seen.inflation, MOST_ALIKE * explained))
    alike = [(one.candidate.name, other) for one, other in tried if other.energy - after.energy <= slack]
    rivals = [other for name, other in alike if name != best.candidate.name]
    twins = [name for name, _ in alike]
    twins += [name for name in _collinear(best, seen) if name not in {one.candidate.name for one, _ in tried}]
    return Found(
        best.candidate.name,
        _share(first, now, after, bench),
        after.held_fit_percent - now.held_fit_percent,
        p_value(best, seen, bench),
        tuple(dict.fromkeys([best.candidate.name, *twins])),
        now,
        after,
        rivals[0] if rivals else None,
    )


def _collinear(best: Score, seen: Round) -> list[str]:
    """Effects whose columns span what those of the best do."""
    found = []
    for one in best_of_each(seen.scores):
        if one.directions.size and best.directions.size:
            cosines = np.linalg.svd(one.directions.T @ best.directions, compute_uv=False)
            if cosines.min() > COLLINEAR and one.directions.shape[1] == best.directions.shape[1]:
                found.append(one.candidate.name)
    return found
