"""Experiments that could tell the causes of a diagnosis apart, as blocks that a record of the configuration takes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from robotid.config.excitation import excitation
from robotid.config.schema import Config
from robotid.diagnosis.experiment import default_speed_controller, design_discriminating_experiment
from robotid.diagnosis.results import Cause, Diagnosis
from robotid.diagnosis.search.state import Found, SearchResult
from robotid.signals.reference import Reference
from robotid.simulate.closed_loop.controller import Controller
from robotid.stages.excite import realise
from robotid.stages.ingestion.virtual import controller_of

LARGE, SMALL = 1.0, 0.15  # of the largest speed on record
LONG, SHORT = 5.0, 1.0  # periods [s]


def separated(settings: Config, diagnosis: Diagnosis, growth: SearchResult) -> Diagnosis:
    """The diagnosis with an experiment for every cause that has a twin."""
    found = {f.effect: f for f in growth.causes if f.rival is not None}
    causes = tuple(
        _separated(settings, c, found[c.effect], growth) if c.effect in found else c for c in diagnosis.causes
    )
    return replace(diagnosis, causes=causes)


def _separated(settings: Config, cause: Cause, found: Found, growth: SearchResult) -> Cause:
    assert found.rival is not None
    loop = settings.loop
    known = loop is not None and loop.kind == "speed"
    controller: Controller = (
        controller_of(loop) if loop is not None and known else default_speed_controller(found.after)
    )
    noise = float(np.sqrt(np.mean([w.output for w in growth.bench.whiten])))
    references = dict(_references(growth))
    return replace(
        cause,
        separation=design_discriminating_experiment(
            found.after, found.rival, found.twins[1], references, controller, noise
        ),
    )


def _references(growth: SearchResult) -> Iterator[tuple[str, Reference]]:
    """References of speed by their blocks: slow and fast, small and large, in time and over frequency."""
    records = growth.bench.fitted
    h = records[0].sampling_time
    top = max(float(np.abs(r.dphi_m).max()) for r in records)
    for block in _blocks(top, h):
        yield json.dumps(block), realise(["separating"], excitation(block))[0]


def _blocks(top: float, h: float) -> Iterator[dict[str, Any]]:
    long, short = (h * round(period / h) for period in (LONG, SHORT))
    for share in (SMALL, LARGE):
        amplitude = float(f"{share * top:.2g}")
        yield {"kind": "triangle", "amplitude": amplitude, "period": long, "duration": long, "sampling_time": h}
        yield {"kind": "triangle", "amplitude": amplitude, "period": short, "duration": long, "sampling_time": h}
        low, high = 1.0, min(40.0, round(0.2 / h, 1))
        if low < high:
            wave = {"kind": "multisine", "band": [low, high], "period": long, "peak": amplitude / 2}
            yield wave | {"crest_factor": None, "sampling_time": h}
