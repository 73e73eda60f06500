"""What figures show beside the results of the stages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from robotid.report.evidence.law import Law
from robotid.report.evidence.profile import Profiles
from robotid.report.evidence.response import Coherence, ModelResponse
from robotid.report.evidence.spectrum import ResidualSpectra


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """laws, spectra : by record, of those on which the models can be simulated. responses : by model, the one that the
    fits started from first, the extended one last. coherences : by record, of those with a measured response.
    profiles : of the doubtful parameters, by model.
    """

    laws: Mapping[str, Law] = field(default_factory=dict)
    spectra: Mapping[str, ResidualSpectra] = field(default_factory=dict)
    responses: Mapping[str, ModelResponse] = field(default_factory=dict)
    coherences: Mapping[str, Coherence] = field(default_factory=dict)
    profiles: Mapping[str, Profiles] = field(default_factory=dict)
