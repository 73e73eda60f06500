"""Experiments that could tell the causes of a diagnosis apart, as blocks that a record of the configuration takes."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from robotid.config.excitation import excitation
from robotid.config.schema import Config
from robotid.diagnosis.experiment import Experiments
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.stages.excite import realise
from robotid.stages.ingestion.virtual import controller_of

SPEED_SHARES = (0.15, 1.0)  # of the largest speed on record: dry friction shows at the one, inertia at the other
LONG_PERIOD, SHORT_PERIOD = 5.0, 1.0  # s


def experiments(settings: Config) -> Experiments:
    """The experiments that a configuration could drive, under its speed loop where it has one."""
    loop = settings.loop
    known = loop is not None and loop.kind == "speed"
    return Experiments(references, controller_of(loop) if loop is not None and known else None)


def references(records: Sequence[Record]) -> dict[str, Reference]:
    """References of speed by their blocks: slow and fast, small and large, in time and over frequency, none faster than
    the records."""
    h = records[0].sampling_time
    top = max(float(np.abs(r.dphi_m).max()) for r in records)
    return {json.dumps(block): realise(["discriminating"], excitation(block))[0] for block in _blocks(top, h)}


def _blocks(top: float, h: float) -> Iterator[dict[str, Any]]:
    long, short = (h * round(period / h) for period in (LONG_PERIOD, SHORT_PERIOD))
    for share in SPEED_SHARES:
        amplitude = float(f"{share * top:.2g}")
        yield {"kind": "triangle", "amplitude": amplitude, "period": long, "duration": long, "sampling_time": h}
        yield {"kind": "triangle", "amplitude": amplitude, "period": short, "duration": long, "sampling_time": h}
        low, high = 1.0, min(40.0, round(0.2 / h, 1))
        if low < high:
            wave = {"kind": "multisine", "band": [low, high], "period": long, "peak": amplitude / 2}
            yield wave | {"crest_factor": None, "sampling_time": h}
