"""Measured and simulated signals of a record."""

from __future__ import annotations

from robotid.estimate.fitted_model import FittedModel, simulate_record
from robotid.export.write import Columns
from robotid.model.units import on_axis
from robotid.signals.record import Record

UNITS = {"t": "s", "tau_m": "Nm", "phi_m": "rad", "dphi_m": "rad/s", "phi_a": "rad"}


def signal_columns(record: Record, model: FittedModel | None, *, linear: bool) -> Columns:
    """Signals by name and unit, (n,) each; those of a model end in _simulated. linear : of a sliding axis.

    Raises NumericsError where the simulation diverges.
    """
    found = {name: getattr(record, name) for name in UNITS if getattr(record, name) is not None}
    found |= {name: one.values for name, one in record.companions.items()}
    units = UNITS | {name: one.unit for name, one in record.companions.items()}
    units |= {"ref": "rad" if record.ref_kind == "position" else "rad/s"}
    if record.ref is not None:
        found["ref"] = record.ref
    if model is not None:
        simulated = simulate_record(model, record)
        found |= {"phi_m_simulated": simulated.signal("position"), "dphi_m_simulated": simulated.signal("speed")}
    called = on_axis(linear=linear)
    return {f"{name} [{called(units[name.removesuffix('_simulated')])}]": values for name, values in found.items()}
