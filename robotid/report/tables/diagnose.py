"""The diagnosis as tables and JSON: how much is wrong, where, why, and what the data cannot tell from the cause."""

from __future__ import annotations

import json
from math import isfinite

import numpy as np

from robotid.diagnosis.misfit.curve import Curve
from robotid.diagnosis.results import Cause, DetectionLimit, Diagnosis, Event, Rejected, Separation, Tone
from robotid.model.units import sliding, sliding_words
from robotid.numerals import fixed, listed, number, percent, portion, probability, rms
from robotid.report.tables.estimates import estimates_document
from robotid.report.tables.table import Json, Table
from robotid.report.variables import MIN_SHARE, counting_of, ordering_of, variable_of

SHOWN = 12  # bins of a shape that a table shows
ALIKE = 3  # confounded effects that a table shows
VERDICTS = {"clean": "green", "named": "cyan", "partly named": "yellow", "unknown": "yellow", "not explained": "red"}


def tables(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """The verdict with the misfit of each record, where it sits, its causes, and what was rejected."""
    return (
        _verdict(diagnosis),
        _records(diagnosis),
        *_curves(diagnosis),
        *_events(diagnosis),
        *_causes(diagnosis),
        *_separations(diagnosis),
        *_rejected(diagnosis),
        *_shape(diagnosis),
        *_limits(diagnosis),
    )


def brief(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """The verdict and its causes alone."""
    found = (*_events(diagnosis), *_causes(diagnosis), *_separations(diagnosis), *_shape(diagnosis))
    return (_verdict(diagnosis), *found)


def document(diagnosis: Diagnosis) -> Json:
    """The `diagnose --json` document of docs/command-line.md."""
    torque = _torque_unit(diagnosis)
    return {
        "verdict": diagnosis.verdict,
        "model": diagnosis.model,
        "noise_floor": diagnosis.noise_floor,
        "misfit": diagnosis.misfit,
        "unit": diagnosis.unit,
        "causes": [_cause(cause) for cause in diagnosis.causes],
        "events": [_event(event) for event in diagnosis.events],
        "torque_late": diagnosis.late,
        "tones": [_tone(tone) for tone in diagnosis.tones],
        "rejected": [rejected_document(one) for one in diagnosis.rejected],
        "remaining": diagnosis.remaining,
        "remaining_share": diagnosis.remaining_share,
        "torque_errors": diagnosis.torque_errors,
        "limits": {one.effect: _limit(one) for one in diagnosis.limits},
        "shape": None if diagnosis.shape is None else _curve(diagnosis.shape, torque),
        "records": {
            name: {
                "role": m.role,
                "fit_percent": m.fit_percent,
                "rmse": m.rmse,
                "noise_floor": m.noise_floor,
                "misfit": m.misfit,
                "explained_after": m.explained_after,
            }
            for name, m in diagnosis.records.items()
        },
        "where": [_curve(curve, torque) for curve in diagnosis.curves],
        "remarks": diagnosis.remarks,
    }


def _tone(tone: Tone) -> Json:
    return {
        "record": tone.record,
        "from": tone.start,
        "to": tone.end,
        "frequency": tone.frequency,
        "torque": tone.amplitude,
    }


def _torque_unit(diagnosis: Diagnosis) -> str:
    """Of a torque on an axis whose output has this unit, a force where the axis slides."""
    return "Nm" if diagnosis.unit != sliding(diagnosis.unit) else "N"


def sentence(diagnosis: Diagnosis) -> str:
    """The verdict."""
    d, unit = diagnosis, diagnosis.unit
    if d.verdict == "clean":
        if d.torque_errors:
            return f"{d.model} leaves no more than {_passing(d)} would, {rms(d.noise_floor, 2)} {unit}"
        return f"{d.model} leaves nothing to explain beyond the noise of {rms(d.noise_floor, 2)} {unit}"
    if d.verdict == "not explained":
        wrong = f"it is wrong by {rms(d.misfit, 2)} {unit}"
        return f"{d.model} does not simulate the records that it was fitted to: {wrong}; `robotid check` examines them"
    causes = ", and ".join(map(_clause, d.causes))
    if d.verdict == "named" and not d.causes:
        happened = ", and ".join(_on_axis(d, _happened(event, _torque_unit(d))) for event in d.events)
        rest = f"no more than {_passing(d)} would" if d.torque_errors else "nothing to explain"
        return f"{d.model} leaves {rest} but what happened once: {happened}"
    if d.verdict in ("named", "partly named"):
        among = " among others" if d.verdict == "partly named" else ""
        return f"{d.model} lacks{among} {causes}{remainder(d)}"
    if d.apart:
        wrong = rms(max(d.records[name].misfit for name in d.apart), 2)
        return f"{d.model} leaves noise on the records of its fit and is wrong by {wrong} {unit} on {listed(d.apart)}"
    if d.is_hidden:
        return f"{d.model} leaves {rms(d.noise_floor, 2)} {unit} that may be noise, and would hide whatever is missing"
    place = "" if d.shape is None else f"; it {_on_axis(d, ordering_of(d.shape))}"
    known = f"{d.model} lacks {causes}, and more" if causes else f"{d.model} is wrong by {rms(d.misfit, 2)} {unit}"
    return f"{known} that {no_effect(d)} explains{place}"


def no_effect(d: Diagnosis) -> str:
    """No effect, in words that claim no more than was examined."""
    return "no effect that was examined in time" if d.is_cut_short else "no effect of the catalogue"


def _passing(d: Diagnosis) -> str:
    """The errors of the torque for which all that is left passes."""
    return f"errors of the torque of {rms(d.torque_errors, 2)} {_torque_unit(d)}"


def _on_axis(d: Diagnosis, text: str) -> str:
    """A text in the words of the axis."""
    return sliding_words(text) if d.unit == sliding(d.unit) else text


def remainder(d: Diagnosis) -> str:
    """How much of the misfit the causes leave, as the end of a sentence."""
    if all(cause.explained_of for cause in d.causes):
        return ""
    grown = d.remaining > d.misfit
    level = f"{rms(d.remaining, 2)} {f'{d.unit} after' if grown else 'of'} {rms(d.misfit, 2)} {d.unit}"
    if d.torque_errors:  # weighed by these nothing remains
        return f"; what remains, {level}, is no more than {_passing(d)} would cause"
    left = f"{portion(d.remaining_share)} of the misfit's energy remains"
    if grown:  # what weighs most is gone, and what is slow has grown
        return f"; weighed by the noise of every frequency {left}, but the simulation errs by more than before, {level}"
    return f"; {left}, {level}"


def _clause(cause: Cause) -> str:
    """A cause as part of a sentence."""
    others = [twin for twin in cause.twins if twin != cause.effect]
    alternatives = f" (or {', '.join(others)}: these data cannot tell)" if others else ""
    of = f" of {cause.explained_of}" if cause.explained_of else ""
    return f"{cause.effect}{alternatives}, which explains {portion(cause.explained)}{of}"


def _happened(event: Event, unit: str) -> str:
    """An event as part of a sentence."""
    until = f" to {number(event.end, 4)}" if event.kind == "bump" else ""
    size = f"{number(event.torque, 2)} {unit}"
    return f"a {_kind(event)} by {size} in {event.record}, from {number(event.start, 4)}{until} s"


def _kind(event: Event) -> str:
    kind = f"gradual {event.kind}" if event.gradual else event.kind
    return f"{kind} of {'friction' if event.friction else 'torque'}"


def rejected_document(one: Rejected) -> Json:
    """An effect that was tried and rejected."""
    return {
        "effect": one.effect,
        "explained": one.explained,
        "heldout_gain": one.heldout_gain,
        "why": one.why,
    }


def _cause(cause: Cause) -> Json:
    found: dict[str, Json] = {
        "effect": cause.effect,
        "parameters": estimates_document(cause.parameters, f"{cause.effect}."),
        "explained": cause.explained,
        "heldout_gain": cause.heldout_gain,
        "p_value": cause.p_value,
        "class": cause.twins,
        "confounded_with": [{"effect": one.effect, "correlation": one.correlation} for one in cause.confounded_with],
    }
    if cause.explained_of:
        found["explained_of"] = cause.explained_of
    if cause.beside:
        found["beside"] = cause.beside
    if cause.separation is not None:
        s = cause.separation
        found["separate_by"] = {"excite": _block(s), "against": s.against, "ratio": s.ratio}
    return found


def _event(event: Event) -> Json:
    return {
        "record": event.record,
        "kind": event.kind,
        "of": "friction" if event.friction else "torque",
        "gradual": event.gradual,
        "from": event.start,
        "to": event.end,
        "torque": event.torque,
        "std": event.std,
        "p_value": event.p_value,
    }


def _limit(one: DetectionLimit) -> Json:
    """None where the effect is invisible."""
    return {one.symbol: one.size, "unit": one.unit} if isfinite(one.size) else None


def _block(separation: Separation) -> Json:
    """What goes under `excite:` of a record."""
    block = json.loads(separation.excite)
    inner: Json = block.get("excite", block)
    return inner


def _curve(curve: Curve, unit: str) -> Json:
    """A curve of the missing torque, in this unit."""
    return {
        "along": curve.along,
        "x": curve.x.tolist(),
        "x_unit": curve.unit,
        "missing_torque": curve.missing_torque.tolist(),
        "spread": curve.spread.tolist(),
        "count": curve.count.tolist(),
        "order": curve.order,
        "unit": unit,
    }


def _verdict(diagnosis: Diagnosis) -> Table:
    unit = diagnosis.unit
    facts = (
        ("verdict", diagnosis.verdict),
        (f"noise floor [{unit}]", rms(diagnosis.noise_floor)),
        (f"misfit beyond it [{unit}]", rms(diagnosis.misfit)),
        (f"what the causes leave [{unit}]", rms(diagnosis.remaining)),
        *(
            [("share of its energy that they leave [%]", percent(diagnosis.remaining_share))]
            if any(not cause.explained_of for cause in diagnosis.causes)
            else []
        ),
    )
    return Table(f"Diagnosis of {diagnosis.model}", ("", ""), facts, "\n".join(diagnosis.remarks), VERDICTS)


def _records(diagnosis: Diagnosis) -> Table:
    unit = diagnosis.unit
    rows = tuple(
        (
            name,
            m.role,
            fixed(m.fit_percent),
            rms(m.rmse),
            rms(m.noise_floor),
            rms(m.misfit),
            percent(m.explained_after),
        )
        for name, m in diagnosis.records.items()
    )
    errors = (f"RMSE [{unit}]", f"noise floor [{unit}]", f"misfit [{unit}]")
    return Table("Records", ("record", "role", "fit [%]", *errors, "explained by the causes [%]"), rows)


def _curves(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """Where the missing torque sits, a row a variable that accounts for something."""
    curves = [c for c in diagnosis.curves if len(c.x)]
    shown = [c for c in curves if c.order >= MIN_SHARE or c.along == "frequency"]
    rows = tuple((variable_of(c), counting_of(c), _order(c), *_largest(diagnosis, c)) for c in shown)
    columns = ("variable", "torque counted", "accounts for [%]", "largest missing torque [Nm]", "there", "unit")
    note = "accounts for: share of the missing torque's variance that its mean along the variable explains"
    if rest := list(dict.fromkeys(variable_of(c) for c in curves if c not in shown)):
        less = [name for name in rest if name not in {variable_of(c) for c in shown}]
        note += f"\nless than {portion(MIN_SHARE, 0)}: {', '.join(less)}" if less else ""
    return (Table("Where the misfit sits", columns, rows, note),) if curves else ()


def _order(curve: Curve) -> str:
    return "-" if curve.along == "frequency" else percent(curve.order)


def _largest(diagnosis: Diagnosis, curve: Curve) -> tuple[str, str, str]:
    """The largest missing torque, the value of the variable there, and its unit; the name of a record."""
    k = int(np.nanargmax(np.abs(curve.missing_torque))) if np.isfinite(curve.missing_torque).any() else 0
    largest, there, names = number(float(curve.missing_torque[k]), 3), float(curve.x[k]), list(diagnosis.missing)
    if curve.along.startswith("record") and 0 <= there < len(names):
        return largest, names[int(there)], ""
    return largest, number(there, 3), curve.unit


def _causes(diagnosis: Diagnosis) -> tuple[Table, ...]:
    if not diagnosis.causes:
        return ()
    rows = tuple(
        (
            cause.effect,
            f"{percent(cause.explained)}{f' of {cause.explained_of}' if cause.explained_of else ''}",
            fixed(cause.heldout_gain),
            probability(cause.p_value),
            ", ".join(twin for twin in cause.twins if twin != cause.effect) or "-",
            ", ".join(f"{one.effect} {fixed(one.correlation)}" for one in cause.confounded_with[:ALIKE]) or "-",
        )
        for cause in diagnosis.causes
    )
    columns = ("effect", "explains [%]", "held-out gain [% points]", "p", "indistinguishable from", "correlated with")
    values = tuple(
        (p.name, number(p.value, 4), number(p.std_robust, 2), p.unit, p.remark)
        for cause in diagnosis.causes
        for p in cause.parameters
    )
    note = (
        "explains: share of the misfit's energy beside the causes above, every frequency weighed by the noise that it"
        " has; all shares and what remains make 100 %\n"
        "correlated with: other effects, and the correlation of their responses on these motions"
    )
    return (
        Table("Causes", columns, rows, note),
        Table("Their parameters", ("parameter", "value", "sd", "unit", "remark"), values),
    )


def _events(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """What happened once, a row an event."""
    rows = tuple(
        (
            event.record,
            _kind(event),
            number(event.start, 4),
            number(event.end, 4),
            number(event.torque, 3),
            number(event.std, 2),
            probability(event.p_value),
        )
        for event in diagnosis.events
    )
    columns = ("record", "event", "from [s]", "to [s]", "torque at the motor [Nm]", "sd [Nm]", "p")
    note = "an event happened once and is no property of the machine: causes are sought without it"
    return (Table("Events", columns, rows, note),) if rows else ()


def _limits(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """The smallest size of every effect that would have been seen, and below it what is invisible."""
    rows = tuple((o.effect, o.symbol, number(o.size, 2), o.unit) for o in diagnosis.limits if isfinite(o.size))
    unseen = [one.effect for one in diagnosis.limits if not isfinite(one.size)]
    note = "of effects that the model lacks, all its parameters refitted; what is smaller may be there"
    note += f"\ninvisible in these records: {', '.join(unseen)}" if unseen else ""
    return (Table("Detection limits", ("effect", "symbol", "would be seen from", "unit"), rows, note),) if rows else ()


def _separations(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """Experiments, each with what goes into a record, below the table to be copied."""
    found = [(c.effect, c.separation) for c in diagnosis.causes if c.separation is not None]
    rows = tuple((effect, s.against, number(s.ratio, 3)) for effect, s in found)
    blocks = (f"{effect} or {s.against}? excite: {json.dumps(_block(s))}" for effect, s in found)
    note = "\n".join(("difference: of the two models' outputs in that experiment, RMS over the noise", *blocks))
    columns = ("effect", "to be distinguished from", "difference")
    return (Table("Experiments that distinguish causes", columns, rows, note),) if found else ()


def _rejected(diagnosis: Diagnosis) -> tuple[Table, ...]:
    return rejected_table("Tried and rejected", diagnosis.rejected)


def rejected_table(title: str, rejected: tuple[Rejected, ...]) -> tuple[Table, ...]:
    """A row an effect, with the reason."""
    rows = tuple((r.effect, percent(r.explained), fixed(r.heldout_gain), r.why) for r in rejected)
    columns = ("effect", "explains [%]", "held-out gain [% points]", "why not")
    return (Table(title, columns, rows),) if rows else ()


def _shape(diagnosis: Diagnosis) -> tuple[Table, ...]:
    """The missing torque that nothing explains, at no more than a dozen places."""
    curve = diagnosis.shape
    if curve is None or not len(curve.x):
        return ()
    chosen = np.unique(np.linspace(0, len(curve.x) - 1, min(SHOWN, len(curve.x))).round().astype(int)).tolist()
    rows = tuple(
        (number(float(curve.x[k]), 3), number(float(curve.missing_torque[k]), 3), number(float(curve.spread[k]), 2))
        for k in chosen
    )
    head = f"{variable_of(curve)} [{curve.unit}]" if curve.unit else variable_of(curve)
    return (Table("Shape of what is unknown", (head, "missing torque [Nm]", "spread [Nm]"), rows),)
