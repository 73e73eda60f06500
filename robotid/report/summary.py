"""The answer in one paragraph: how well the model simulates the machine, what it gets wrong, what caused it, and what
the extension gained. As much of it as the stages that have run can tell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite

from robotid.catalogue import EFFECTS
from robotid.diagnosis.clock import RecordedLate
from robotid.diagnosis.remarks import SHAPELESS, UNEXPLAINED
from robotid.diagnosis.results import Cause, Diagnosis
from robotid.estimate.result import End, Estimate, FitResult
from robotid.extension.results import Extension, Score
from robotid.model.companion import companion_of
from robotid.model.structure import changed, is_change
from robotid.numerals import ROUNDING, capitalised, fixed, listed, portion, significant
from robotid.report.drawing.location import best_of_each, ordering
from robotid.report.events import described, not_accounted_for
from robotid.report.findings import Findings
from robotid.report.style.axes import axis_label
from robotid.report.tables.diagnose import no_effect
from robotid.validation.identifiability import UNSEEN_SHARE, hidden_by_errors
from robotid.validation.results import RecordValidation

MAX_NAMED = 3  # records that are named one by one
MIN_REMAINING = 0.1  # of the noise: what is less is called nothing
MUCH_WORSE = 2.0  # times the misfit of the records of the fit: what a model misses of others is stated, too
MIN_ORDER = 0.2  # share of the variance from which a variable is named


def summary(findings: Findings) -> str:
    """The paragraph."""
    return " ".join(capitalised(sentence) for sentence in _sentences(findings))


def remarks(findings: Findings) -> tuple[str, ...]:
    """What to know of the fit and of the diagnosis beside the answer, a sentence each; not what the answer tells."""
    fits, found = findings.fits, findings.diagnosis
    of_fit = () if fits is None else fits.models[fits.best].remarks
    of_diagnosis = () if found is None or found.apart else found.remarks
    doubts = (*of_fit, *(one for one in of_diagnosis if one not in (SHAPELESS, UNEXPLAINED)))
    return tuple(f"{capitalised(one)}." for one in doubts)


def robot_summary(axes: Mapping[str, Findings]) -> str:
    """The paragraph on a robot of several axes: how well their models simulate, and on which axes what is missing. Of
    one axis alone it is the axis' own."""
    if len(axes) == 1:
        return summary(*axes.values())
    best = {axis: f.validation.models[f.validation.best] for axis, f in axes.items() if f.validation is not None}
    parts = [f"{len(axes)} axes."]
    for used, where in ((True, "On the records that they were fitted to,"), (False, "On held-out records,")):
        levels = {
            axis: min(values)
            for axis, model in best.items()
            if (values := [record.fit_percent for record in model.records.values() if record.used == used])
        }
        if levels:
            low, high = min(levels, key=levels.__getitem__), max(levels, key=levels.__getitem__)
            parts.append(
                f"{where} the models fit from {fixed(levels[low])} % ({low}) to {fixed(levels[high])} % ({high})."
            )
    diagnosed = {axis: f.diagnosis for axis, f in axes.items() if f.diagnosis is not None}
    for verdict in dict.fromkeys(d.verdict for d in diagnosed.values()):
        found = {axis: d.causes for axis, d in diagnosed.items() if d.verdict == verdict}
        named = [f"{axis} ({listed([c.effect for c in causes])})" if causes else axis for axis, causes in found.items()]
        parts.append(f"{verdict[0].upper()}{verdict[1:]}: {listed(named)}.")
    return " ".join(parts)


def _sentences(f: Findings) -> Iterator[str]:
    yield from _simulates(f)
    yield from _ended(f)
    if f.diagnosis is not None:
        if f.diagnosis.late:
            yield f"{RecordedLate(f.diagnosis.late).remark}."
        yield from _lacks(f, f.diagnosis)
    if f.extension is not None:
        yield from _gained(f, f.extension)


def _ended(f: Findings) -> Iterator[str]:
    """How the fits ended that did not converge, those that ended alike in one sentence."""
    fits = dict[str, FitResult]()
    if f.fits is not None:
        fits[f.fits.best] = f.fits.models[f.fits.best]
    if (extension := f.extension_that_adds) is not None:
        fits[f"the extended {extension.model}"] = extension.fit
    for end in dict.fromkeys(fit.end for fit in fits.values() if not fit.converged):
        names = [name for name, fit in fits.items() if fit.end is end]
        verb = "" if end is not End.INTERRUPTED else "was " if len(names) == 1 else "were "
        yield f"the {'fit' if len(names) == 1 else 'fits'} of {listed(names)} {verb}{end.value}."


def _simulates(f: Findings) -> Iterator[str]:
    """How well the model simulates, or how far the identification has come."""
    if f.validation is not None:
        yield from _validated(f)
    elif f.fits is not None:
        best = f.fits.models[f.fits.best]
        fits = _range(list(best.fit_percent.values()))
        yield (
            f"model {best.name} of {f.robot} was fitted to {_records(list(best.records))} and simulates the motor"
            f" {best.output} there with a fit of {fits} %."
        )
        yield "It has not been validated yet."
    elif f.flex is not None and f.flex.guesses:
        yield from _started(f)
    elif f.rigid is not None:
        yield from _rigid(f)
    else:
        yield from _recorded(f)


def _validated(f: Findings) -> Iterator[str]:
    assert f.validation is not None
    best = f.validation.models[f.validation.best]
    used = {name: record for name, record in best.records.items() if record.used}
    apart = {name: record for name, record in best.records.items() if not record.used}
    groups = [f"{_fits(f, used)} on the records it was fitted to"] * bool(used)
    groups += [f"{_fits(f, apart)} on held-out records"] * bool(apart)
    parts = listed(groups) or "nothing: it diverges on every record"
    yield f"model {f.validation.best} of {f.robot} simulates the motor {best.output} with a fit of {parts}."
    if not apart:
        yield "No record was held out, so this does not tell how well it does on motions it has not seen."
    if f.pieces is not None and f.diagnosis is not None:
        alone = f.diagnosis.horizon is not None
        who, whose = ("diagnosis simulates", "its") if alone else ("fit and the diagnosis simulate", "their")
        pieces = f"pieces of {significant(f.pieces)} s, each from a first state of its own"
        yield f"The {who} {pieces}; the fits in {whose} tables are of these."
    unseen = [i for i in best.identifiability if i.verdict == "unseen"]
    hidden = [i.name for i in unseen if hidden_by_errors(i)]
    if len(hidden) < len(unseen):
        yield f"These records do not determine {listed([i.name for i in unseen if i.name not in hidden], 'or')}."
    if hidden:
        right = f"the other {axis_label('torques', f.units)} are right to {portion(UNSEEN_SHARE, 0)}"
        yield f"These records determine {listed(hidden)} only if {right}."
    yield from (f"that is not enough: {failure}." for failure in f.validation.failed)


def _fits(f: Findings, records: Mapping[str, RecordValidation]) -> str:
    if len(records) <= MAX_NAMED:
        return listed([f"{fixed(record.fit_percent)} % ({_remarked(f, name)})" for name, record in records.items()])
    eventful = [name for name in records if f.events_of(name)]
    remark = f" (events in {_records(eventful)} not accounted for)" if eventful else ""
    return f"{_range([record.fit_percent for record in records.values()])} %{remark}"


def _remarked(f: Findings, record: str) -> str:
    events = f.events_of(record)
    return f"{record}, its {not_accounted_for(events)}" if events else record


def _range(values: list[float]) -> str:
    low, high = fixed(min(values)), fixed(max(values))
    return low if low == high else f"{low} to {high}"


def _records(names: list[str]) -> str:
    return listed(names) if len(names) <= MAX_NAMED else f"{len(names)} records"


def _started(f: Findings) -> Iterator[str]:
    assert f.flex is not None
    notches = [r.notch / 6.283185307179586 for r in f.flex.readings if r.notch is not None]
    where = f", with a notch at {_few(notches)} Hz" if notches else ""
    yield f"{_number(len(f.flex.frfs), 'frequency response')} of {f.robot} were measured{where}."
    yield f"They give {listed([_value(f, e) for e in f.flex.parameters])}; no model has been fitted by simulation yet."


def _few(values: list[float]) -> str:
    low, high = significant(min(values)), significant(max(values))
    return low if low == high else f"{low} to {high}"


def _rigid(f: Findings) -> Iterator[str]:
    assert f.rigid is not None
    errors = list(f.rigid.torque_error_percent.values())
    explained = f"; the {axis_label('torque', f.units)} is met to {_few(errors)} %" if errors else ""
    values = listed([_value(f, e) for e in f.rigid.parameters]) or "nothing to estimate"
    yield f"as a rigid joint {f.robot} has {values}{explained}."
    yield "No model has been fitted by simulation yet."


def _recorded(f: Findings) -> Iterator[str]:
    if f.recordings is not None:
        records = f.recordings.records
        length, are = significant(sum(r.duration for r in records)), _are(len(records))
        yield f"{_number(len(records), 'record')} of {f.robot}, {length} s in all, {are} ready."
        yield "No model has been fitted yet."
    elif f.excitation is not None:
        count = len(f.excitation.references)
        yield f"{_number(count, 'reference signal')} for {f.robot} {_are(count)} ready; nothing has been recorded yet."


def _number(count: int, noun: str, plural: str = "") -> str:
    return f"{count} {noun if count == 1 else plural or f'{noun}s'}"


def _are(count: int) -> str:
    return "is" if count == 1 else "are"


def _value(f: Findings, e: Estimate) -> str:
    unit = f.units(e.unit)
    return f"{e.name} = {significant(e.value, 4)}{'' if unit in ('', '1') else f' {unit}'}"


def _lacks(f: Findings, d: Diagnosis) -> Iterator[str]:
    """What the model gets wrong, and what caused it."""
    unit = f.units(d.unit)
    noise = f"{significant(d.noise_floor, 2) if d.noise_floor > ROUNDING else 0} {unit}"
    if d.verdict == "clean":
        yield f"What it leaves is {_only_noise(f, d, noise)}"
        yield from _wrong_elsewhere(f, d)
        yield from _invisible(d)
        return
    if d.apart:
        yield f"What it leaves of the records of its fit is noise of {noise} RMS."
        yield from _wrong_elsewhere(f, d)
        yield "No parameters simulate both, so that something is missing: fit these records, too, to look for it."
        return
    if d.verdict == "not explained":
        wrong = f"{significant(d.misfit, 2)} {unit} RMS"
        yield f"it does not simulate the records that it was fitted to: it is wrong by {wrong}. No cause can be named."
        return
    if d.verdict == "named" and not d.causes:
        yield from _happened(f, d)
        yield f"Without it {d.model} leaves {_only_noise(f, d, noise)}"
        yield from _invisible(d)
        return
    if d.is_hidden:
        yield f"What it leaves, {noise} RMS, may be noise, and so much that whatever is missing would not show."
        yield from _much_worse_elsewhere(f, d)
        return
    yield f"beyond noise of {noise} it is wrong by {significant(d.misfit, 2)} {unit} RMS{_place(f, d)}."
    yield from _happened(f, d)
    if d.causes:
        lead = "The cause is" if len(d.causes) == 1 else "The causes are"
        lead = f"Part of it is explained: {lead.lower()}" if d.verdict == "partly named" else lead
        yield f"{lead} {listed([_cause(f, c) for c in d.causes])}."
        yield from _twins(d)
    if d.verdict == "unknown":
        rest = f"the {significant(d.remaining, 2)} {unit} that remain" if d.causes else "it"
        shape = "" if d.shape is None else f"; what is missing {ordering(d.shape, f.units)}"
        yield f"{no_effect(d)} explains {rest}, so the cause is unknown{shape}."
        yield from _much_worse_elsewhere(f, d)
    elif d.causes and d.remaining < d.misfit:
        verb = "Together they leave" if len(d.causes) > 1 else "It leaves"
        left = f"{significant(d.remaining, 2)} {unit}" if d.remaining > MIN_REMAINING * d.noise_floor else "nothing"
        yield f"{verb} {left} beyond the noise{_what_is_left(f, d) if left != 'nothing' else ''}."
    if d.causes and d.shape is not None and d.verdict != "unknown":
        yield f"what is left is no effect of the catalogue; it {ordering(d.shape, f.units)}."


def _happened(f: Findings, d: Diagnosis) -> Iterator[str]:
    """What happened once in a record."""
    for event in d.events[:MAX_NAMED]:
        yield f"In {event.record} there is {described(event, f.units)}: an event, not a property of the machine."
    if len(d.events) > MAX_NAMED:
        yield f"There are {len(d.events) - MAX_NAMED} more events."
    if (e := f.extension_that_adds) is not None:
        fits = {name: score.fit_percent for name, score in e.before.items() if e.events_of(name)}
        if fits:
            them = "it" if len(e.events) == 1 else "them"
            levels = listed([f"{name} to {fixed(fits[name])} %" for name in list(fits)[:MAX_NAMED]])
            yield f"With {them} accounted for, {e.model} simulates {levels}; its extension is compared with this fit."


def _wrong_elsewhere(f: Findings, d: Diagnosis) -> Iterator[str]:
    """What a model gets wrong on held-out records although it leaves but noise on those of its fit."""
    wrong = {name: m.misfit for name, m in d.records.items() if m.role == "validate" and m.misfit > m.noise_floor}
    if wrong:
        yield f"{_wrong_by(f, d, wrong)} beyond the noise, for reasons that the records of the fit do not show."


def _much_worse_elsewhere(f: Findings, d: Diagnosis) -> Iterator[str]:
    """The held-out records on which a model is far more wrong than on those of its fit."""
    wrong = {n: m.misfit for n, m in d.records.items() if m.role == "validate" and m.misfit > MUCH_WORSE * d.misfit}
    if wrong:
        yield f"{_wrong_by(f, d, wrong)}."


def _wrong_by(f: Findings, d: Diagnosis, wrong: Mapping[str, float]) -> str:
    """On which held-out records a model is wrong, and by how much at most. wrong : misfits by record."""
    size = significant(max(wrong.values()), 2)
    return f"On {_records(list(wrong))}, held out of the fit, it is wrong by {size} {f.units(d.unit)} RMS"


def _only_noise(f: Findings, d: Diagnosis, noise: str) -> str:
    """What a model without a cause leaves, as the end of a sentence. noise : its size, with the unit."""
    if not d.torque_errors:
        return f"noise of {noise} RMS: there is nothing else to explain."
    return f"{noise} RMS, {_passes_for(f, d)}: nothing stands out of these."


def _what_is_left(f: Findings, d: Diagnosis) -> str:
    """How much of the misfit the causes leave, or what it passes for: weighed by torque errors it is no share."""
    if d.torque_errors:
        return f", {_passes_for(f, d)}"
    return f" ({portion(d.remaining_share, 0)} of the misfit's energy, weighed by the noise)"


def _passes_for(f: Findings, d: Diagnosis) -> str:
    return f"no more than errors of the torque of {significant(d.torque_errors, 2)} {f.units('Nm')} would"


def _invisible(d: Diagnosis) -> Iterator[str]:
    """Effects that may be there for all that these records show."""
    unseen = [one.effect for one in d.limits if not isfinite(one.size)]
    if d.limits:
        rest = f"; {listed(unseen)} cannot be seen in them at all" if unseen else ""
        yield f"From which size on these records would have shown each effect stands in the table of limits{rest}."


def _place(f: Findings, d: Diagnosis) -> str:
    curves = [c for c in best_of_each(d.curves) if c.along != "frequency" and c.order > MIN_ORDER]
    missing = axis_label("torque", f.units)
    return f"; the {missing} that it lacks {ordering(curves[0], f.units)}" if curves else ""


def _cause(f: Findings, cause: Cause) -> str:
    """An effect with what it is and does: "motor.stribeck (torque missing at small speed only; explains 97 %)"."""
    name, description = cause.effect, ""
    if is_change(cause.effect):
        record, name = changed(cause.effect)
        by = next((f" by {significant(p.value)} {f.units(p.unit)}" for p in cause.parameters), "")
        description = f"differs in {record}{by}; "
    elif (effect := companion_of(cause.effect.rpartition(".")[2])[0]) in EFFECTS:
        description = f"{EFFECTS[effect].signature}; "
    of = f" of {cause.explained_of}" if cause.explained_of else ""
    return f"{name} ({description}explains {portion(cause.explained, 0)}{of})"


def _twins(d: Diagnosis) -> Iterator[str]:
    for cause in d.causes:
        others = [twin for twin in cause.twins if twin != cause.effect]
        if others:
            separate = "" if cause.separation is None else "; an experiment that would is given below"
            yield f"These data cannot tell {cause.effect} from {listed(others, 'or')}{separate}."


def _gained(f: Findings, e: Extension) -> Iterator[str]:
    """What the extension gained, on held-out records where there are any."""
    if not e.added:
        if f.diagnosis is None or f.diagnosis.verdict != "clean":
            yield "Nothing was added to the model."
        return
    both = [name for name in e.after if name in e.before]
    apart = [name for name in both if not e.after[name].used]
    names = apart or both
    parts = [_risen(e.before[name], e.after[name], name, len(names)) for name in names[:MAX_NAMED]]
    further = f", and {len(names) - MAX_NAMED} more" if len(names) > MAX_NAMED else ""
    kind = f"held-out {'record' if len(names) == 1 else 'records'} " if apart else ""
    pieces = "" if f.pieces is None else f", simulated in pieces of {significant(f.pieces)} s,"
    yield f"With {listed(list(e.added))} added{pieces or ','} the fit of {kind}{listed(parts)}{further}."
    if not apart:
        yield "No record was held out, so part of this gain may be fitted noise."
    if e.dropped:
        yield f"Dropped in the final fit, for it no longer earned its place: {listed([r.effect for r in e.dropped])}."


def _risen(before: Score, after: Score, name: str, count: int) -> str:
    verb = "goes" if count == 1 else "went"
    change = 100 * (1 - after.rmse / before.rmse) if before.rmse and isfinite(before.rmse) else 0.0
    error = f" (its RMS error {'falls' if change >= 0 else 'rises'} by {fixed(abs(change), 0)} %)"
    return f"{name} {verb} from {fixed(before.fit_percent)} to {fixed(after.fit_percent)} %{error}"
