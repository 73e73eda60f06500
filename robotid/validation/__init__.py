"""What a model is worth: how well it simulates every record, what its parameters are known by, and what is left over.

Order of reading: `results` (what validation finds out), `procedure` (one model or several, on all records), and the
single questions: `residual_tests` (is there anything left to explain?), `identifiability` with `torque_share` (what do
the records tell of each parameter?), `perturbation` (what is each parameter worth to the fit?), `inverse_dynamics`
(which torque would the measured motion need?), `closed_loop` (how far does the model stray under the controller?),
`bode` (the linearised model beside the measured frequency responses).
"""

from __future__ import annotations

from robotid.validation.procedure import (
    ValidationOptions,
    initial_name,
    validate_model,
    validate_models,
    validate_record,
)
from robotid.validation.results import ModelValidation, RecordValidation, Validation

__all__ = [
    "ModelValidation",
    "RecordValidation",
    "Validation",
    "ValidationOptions",
    "initial_name",
    "validate_model",
    "validate_models",
    "validate_record",
]
