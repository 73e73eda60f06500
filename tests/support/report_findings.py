"""Findings with something in every field, for tests of the report: the paper's joint with a Stribeck effect unknown to
its model, told from a payload on one record."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from robotid.catalogue import assemble
from robotid.diagnosis.events.applied import event_torque
from robotid.diagnosis.misfit.curve import Curve
from robotid.diagnosis.results import Diagnosis, Misfit, Rejected
from robotid.estimate.flexible import FlexReading, FlexResult
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.result import Estimate, FitResult, Fits
from robotid.estimate.rigid import RigidResult
from robotid.extension.results import Extension, Score
from robotid.report.findings import Findings
from robotid.signals.quality import Recordings
from robotid.signals.record import Record
from robotid.signals.reference import Excitation, Reference
from robotid.signals.trace import Trace
from robotid.validation.procedure import ValidationOptions, validate_model
from robotid.validation.results import Validation
from support.diagnosed import EXTENSION, NAMED, PAYLOAD, STRIBECK
from support.judged_records import CONTROLLER, clean_records, clean_responses, model


@cache
def validation() -> Validation:
    """Of a model whose spring is too soft, the initial one, and of the truth."""
    wrong = model({"gear.spring.k1": 1.2e6}, name="m0")
    options = ValidationOptions(controller=CONTROLLER, perturbation=20.0)
    models = {m.name: validate_model(m, clean_records(), clean_responses(), options) for m in (wrong, model({}))}
    return Validation(models, "m", clean_responses())


@cache
def fits() -> Fits:
    start = model({"gear.spring.k1": 1.2e6})
    found = fit_model("m", start.joint, start.parameters, clean_records()[:1], FitOptions())
    return Fits({"m": found, "n": replace(found, name="n")}, "m")


def excitation() -> Excitation:
    return Excitation(tuple(Reference(r.name, r.sampling_time, r.dphi_m, "speed") for r in clean_records()))


def rigid() -> RigidResult:
    found = (Estimate("joint.inertia.J", 0.0346, "kg m2", 1e-4, 1e-4, 0.0, 1.0),)
    return RigidResult(found, np.eye(1), 1.0, {"small": 3.5}, {"small": 20.0}, {"motor.inertia.J": 0.0121}, ())


def flex() -> FlexResult:
    values = {"gear.spring.k1": 1.46e6}
    reading = FlexReading("small", 35.9, 61.0, 82.6, 0.0121, 1.46e6, values, {"gear.spring.k1": 0.01}, 1.1, 1e-3)
    found = (Estimate("gear.spring.k1", 1.46e6, "Nm/rad", 1e4, 1e4, 0.0, 1e8),)
    return FlexResult(clean_responses(), (reading,), found, (), values, ())


CURVES = (
    ("dphi_m, by direction", "rad/s", 10.0, lambda x: -0.2 * np.exp(-((x / 1.5) ** 2)), 0.92),
    ("dphi_m", "rad/s", 10.0, lambda x: -0.2 * np.exp(-((x / 1.5) ** 2)) * np.sign(x), 0.91),
    ("reversal", "s", 0.4, lambda x: -0.18 * np.exp(-np.abs(x) / 0.05) * np.sign(x), 0.55),
    ("twist", "rad", 1e-3, lambda x: -40 * x, 0.22),
    ("phi_m mod 2 pi", "rad", np.pi, lambda x: 0.01 * np.sin(x), 0.01),
    ("phi_a, by speed", "rad", 0.1, lambda x: 0.02 * x, 0.02),
    ("ddphi_m", "rad/s2", 300.0, lambda x: 1e-4 * x, 0.05),
    ("tau_m", "Nm", 8.0, lambda x: 4e-3 * x, 0.08),
    ("t", "s", 1.5, lambda x: 0.02 * np.cos(x), 0.0),
)


def curves() -> tuple[Curve, ...]:
    """Along every variable."""
    found = [_curve(*one) for one in CURVES]
    two, bands = np.arange(2.0), np.geomspace(1.0, 300.0, 12)
    found.append(Curve("record", "1", two, np.array([0.01, -0.01]), np.full(2, 0.05), np.full(2, 3000.0), 0.02))
    found.append(Curve("frequency", "Hz", bands, 0.1 / bands, np.zeros(12), np.ones(12), 0.0))
    return tuple(found)


def _curve(along: str, unit: str, reach: float, law: object, order: float) -> Curve:
    assert callable(law)
    x = reach * np.linspace(-1, 1, 25) if not along.startswith(("t", "phi_m mod")) else reach * np.linspace(0, 2, 25)
    x = x if not along.startswith(("twist", "tau")) else reach * np.linspace(-1, 1, 25)
    return Curve(along, unit, x, law(x), np.full(25, 0.03), np.full(25, 240.0), order, 6.0 if "speed" in along else 1.0)


def diagnosis() -> Diagnosis:
    """Two causes, one with a twin, and effects that were tried in vain."""
    missing = {r.name: Trace(r.t, -0.2 * np.sign(r.dphi_m), -0.19 * np.sign(r.dphi_m), "Nm") for r in clean_records()}
    tried = [Rejected(f"motor.{name}", share, -0.1, "worse held out") for name, share in TRIED.items()]
    changed = "record_change.large.arm.inertia.J"
    payload = replace(PAYLOAD, effect=changed, twins=(changed,), explained_of="large")
    return replace(
        NAMED,
        model="m",
        records={
            "small": Misfit("estimate", 96.1, 0.132, 0.01, 0.13, 0.98),
            "large": Misfit("validate", 95.0, 0.14, 0.01, 0.139, 0.97),
        },
        causes=(STRIBECK, payload),
        rejected=tuple(tried),
        curves=curves(),
        events=tuple(replace(event, record="small") for event in NAMED.events),
        missing=missing,
    )


TRIED = {"cogging": 0.31, "power_friction": 0.27, "position_friction": 0.14, "viscous": 0.05, "constant_torque": 0.01}


def extension() -> Extension:
    """Better on both records, one of them held out."""
    before = {r.name: _score(r, 0.04, fit) for r, fit in zip(clean_records(), (96.1, 95.0), strict=True)}
    after = {r.name: _score(r, 0.002, fit) for r, fit in zip(clean_records(), (99.8, 99.2), strict=True)}
    best = fits().models["m"]
    return replace(EXTENSION, model="m", before=before, after=after, fit=extended(best))


def with_events() -> Findings:
    """Everything, and events in the record small for which the extension accounts."""
    f, (push, step) = findings(), diagnosis().events
    events = (replace(push, start=0.7, end=0.9), replace(step, start=1.2, end=1.5))
    disturbed = tuple(
        replace(r, tau_m=r.tau_m - sum(event_torque(e, r) for e in events if e.record == r.name))
        for r in clean_records()
    )
    return replace(
        f,
        recordings=Recordings(disturbed, ()),
        diagnosis=replace(diagnosis(), events=events),
        extension=replace(extension(), events=events),
    )


def extended(fit: FitResult) -> FitResult:
    """A fit with the Stribeck effect of the cause beside its own parameters."""
    structure = fit.structure.extended("motor.stribeck")
    found = {p.name: p for p in (*fit.parameters, *STRIBECK.parameters)}
    names, own = assemble(structure).names, [p.name for p in fit.parameters]
    covariance = np.diag([found[name].std_robust ** 2 for name in names])
    at = [names.index(name) for name in own]
    covariance[np.ix_(at, at)] = fit.covariance_robust
    return replace(
        fit,
        structure=structure,
        parameters=tuple(found[name] for name in names),
        covariance=covariance,
        covariance_robust=covariance,
    )


def _score(record: Record, error: float, fit: float) -> Score:
    trace = Trace(record.t, record.dphi_m, record.dphi_m + error * np.sin(40 * record.t), "rad/s")
    return Score(record.role, record.role == "estimate", fit, error, trace)


def findings() -> Findings:
    """Everything."""
    return Findings(
        robot="irb",
        excitation=excitation(),
        recordings=Recordings(clean_records(), ()),
        rigid=rigid(),
        flex=flex(),
        fits=fits(),
        validation=validation(),
        diagnosis=diagnosis(),
        extension=extension(),
    )
