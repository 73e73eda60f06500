"""What it costs on the records that a program cannot express some effects."""

from __future__ import annotations

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.fitted_model import simulate_record
from robotid.export.handover.handed_model import Cost, HandedModel
from robotid.signals.metrics import fit_percent

LONGEST = 50_000  # samples of a record that are simulated


def costs(whole: HandedModel, reduced: HandedModel) -> tuple[Cost, ...]:
    """The records as the whole model simulates them, and as the reduced one does, each from the first states that suit
    it best. Long records count with their beginning."""
    found = []
    before, after = whole.model, reduced.model
    for record in whole.records:
        part = record.piece(0, LONGEST) if len(record) > LONGEST else record
        try:
            old = simulate_record(before, part)
        except NumericsError:
            continue
        y, simulated = old.measured(before.output), old.signal(before.output)
        percent, difference = None, None
        try:
            new = simulate_record(after, part).signal(before.output)
            percent, difference = fit_percent(y, new), float(np.sqrt(np.mean((new - simulated) ** 2)))
        except NumericsError:
            pass
        found.append(Cost(record.name, fit_percent(y, simulated), percent, difference, before.unit))
    return tuple(found)
