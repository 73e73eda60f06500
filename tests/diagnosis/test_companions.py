"""What a recorded signal explains is found among several, with the signal; where none does, none is named."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.accompanied import MODEL, record

from robotid.catalogue import assemble
from robotid.diagnosis import diagnose
from robotid.diagnosis.criteria import Criteria
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.result import FitResult
from robotid.estimate.rigid import fit_rigid
from robotid.model.parameters import KnownParameter
from robotid.model.structure import Structure
from robotid.signals.record import Record

HIDDEN = [
    ("motor.pose_inertia[q2]", {"A": 0.004, "B": 0.003, "n": 1.0}),
    ("motor.temperature_friction[gear]", {"c": -0.02, "w0": 30.0}),
    ("motor.known_torque[cell]", {"g": 0.3}),
    ("torque.voltage_sag[bus]", {"c": 0.03, "w0": 48.0}),
    ("motor.known_inertia[pose]", {"s": 1.0}),
    ("motor.coupling[q3]", {"H": 0.02, "A": 0.0, "B": 0.06, "n": 0.0}),
    ("motor.coupling[q2]", {"H": 0.03, "A": 0.02, "B": -0.04, "n": 1.0}),
]


def fitted(structure: Structure, *records: Record) -> FitResult:
    joint = assemble(structure)
    guesses = fit_rigid(joint, joint.parameters(), records).guesses
    start = joint.parameters().with_known({name: KnownParameter(value) for name, value in guesses.items()})
    return fit_model("m1", joint, start, records, FitOptions())


@pytest.mark.parametrize(("effect", "values"), HIDDEN, ids=[effect for effect, _ in HIDDEN])
def test_the_effect_is_named_with_the_signal_that_it_follows(effect: str, values: dict[str, float]) -> None:
    records = record(effect, 1, **values), record(effect, 2, "validate", **values)
    found = diagnose(fitted(MODEL, records[0]), records, Criteria(max_causes=1))
    assert [cause.effect for cause in found.causes] == [effect]
    (cause,) = found.causes
    assert found.verdict == "named"
    assert cause.explained > 0.95
    for estimate in cause.parameters:
        symbol = estimate.name.rpartition(".")[2]
        assert estimate.value == pytest.approx(values[symbol], abs=0.1 * max(map(abs, values.values())))


@pytest.mark.parametrize("seed", [1, 3])
def test_nothing_is_named_where_no_signal_matters(seed: int) -> None:
    records = record("", seed), record("", seed + 1, "validate")
    found = diagnose(fitted(MODEL, records[0]), records)
    assert (found.verdict, found.causes) == ("clean", ())


def test_without_the_signal_no_effect_that_reads_it_is_tried() -> None:
    effect, values = HIDDEN[0]
    records = [
        replace(one, companions={name: c for name, c in one.companions.items() if name == "hall"})
        for one in (record(effect, 1, **values), record(effect, 2, "validate", **values))
    ]
    found = diagnose(fitted(MODEL, records[0]), records, Criteria(max_causes=1, max_refits=2))
    named = [*(cause.effect for cause in found.causes), *(one.effect for one in found.rejected)]
    assert not [name for name in named if "[" in name and "[hall]" not in name]
    assert found.verdict != "clean"


def test_a_fit_of_two_records_reads_the_companions_of_each() -> None:
    """The truth comes out, whatever the other record's companions do."""
    effect, values = HIDDEN[0]
    extended = MODEL.extended(effect)
    fit = fitted(extended, record(effect, 1, **values), record(effect, 2, **values))
    found = {estimate.name: estimate for estimate in fit.parameters}
    assert found[f"{effect}.n"].fixed
    assert found[f"{effect}.A"].value == pytest.approx(0.004, rel=0.05)
    assert found[f"{effect}.B"].value == pytest.approx(0.003, rel=0.05)
    assert found["motor.inertia.J"].value == pytest.approx(0.012, rel=0.05)
