"""What the check of a record finds in columns that were guessed, put right where only one way is open."""

from __future__ import annotations

from dataclasses import replace
from math import pi

from robotid.numerals import plain
from robotid.signals.plausibility import Finding
from robotid.signals.plausibility.alignment import align_speed
from robotid.signals.proposal import Proposal
from robotid.signals.record import Record

SPEED_UNITS = {
    pi / 180: {"phi_m": "deg"},
    180 / pi: {"dphi_m": "deg/s"},
    30 / pi: {"dphi_m": "rpm"},
    1 / 6: {"phi_m": "deg", "dphi_m": "rpm"},
    1 / (2 * pi): {"phi_m": "rad", "dphi_m": "rev/s"},
    2 * pi: {"phi_m": "rev"},
}
"""Recorded speed over derivative of the recorded angle, and the units that make it so."""
SAME = 0.02  # relative deviation from such a factor


def corrected(found: Proposal, record: Record, finding: Finding) -> Proposal | None:
    """A proposal without a fatal finding on the record that it makes, with a remark on what was changed; None where
    only a person knows. Units that a file or a person has given stay."""
    if finding.name == "angle_unit":
        return _with_units(found, {"phi_m": "deg"}, "the encoder's steps are those of degrees")
    if finding.name == "torque_sign":
        torque = found.columns["tau_m"]
        scale = -1.0 if torque.scale is None else -torque.scale
        remark = "torque and motion have opposite signs: tau_m is taken with the other one"
        return replace(
            found, columns=found.columns | {"tau_m": replace(torque, scale=scale)}, remarks=(*found.remarks, remark)
        )
    if finding.name == "speed_scale":
        scale = align_speed(record.phi_m, record.dphi_m, record.sampling_time).scale
        for factor, units in SPEED_UNITS.items():
            if abs(scale / factor - 1.0) < SAME:
                fitting = _with_units(found, units, f"the speed is {plain(scale)} times the derivative of the angle")
                return fitting or _without_speed(found, finding)
    if finding.name.startswith("speed_") and finding.name not in ("speed_size", "speed_exchanged"):
        return _without_speed(found, finding)
    return None


def _with_units(found: Proposal, units: dict[str, str], why: str) -> Proposal | None:
    """The same columns in other units; None where one of them has a unit, or there is no such column."""
    columns = {signal: found.columns.get(signal) for signal in units}
    given = {signal: replace(column, unit=units[signal]) for signal, column in columns.items() if column is not None}
    if len(given) < len(units) or any(column is not None and column.unit for column in columns.values()):
        return None
    listed = " and ".join(f"{signal} is taken to be in {unit}" for signal, unit in units.items())
    return replace(found, columns=found.columns | given, remarks=(*found.remarks, f"{why}: {listed}"))


def _without_speed(found: Proposal, finding: Finding) -> Proposal | None:
    if "dphi_m" not in found.columns:
        return None
    columns = {signal: column for signal, column in found.columns.items() if signal != "dphi_m"}
    remark = f"dphi_m is left out and derived from phi_m: {finding.what}"
    return replace(found, columns=columns, left_out=(*found.left_out, "dphi_m"), remarks=(*found.remarks, remark))
