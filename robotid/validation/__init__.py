"""What a model is worth: how well it simulates every record, what its parameters are known by, and what is left over.

Order of reading: `results` (what validation finds out), `procedure` (one model or several, on all records), and the
single questions: `residual_tests` (is there anything left to explain?), `identifiability` with `torque_share` (what do
the records tell of each parameter?), `perturbation` (what is each parameter worth to the fit?), `inverse_dynamics`
(which torque would the measured motion need?), `closed_loop` (how far does the model stray under the controller?),
`bode` (the linearised model beside the measured frequency responses).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from robotid.lazy import on_first_use

if TYPE_CHECKING:
    from robotid.validation.procedure import ValidationOptions as ValidationOptions
    from robotid.validation.procedure import initial_name as initial_name
    from robotid.validation.procedure import validate_model as validate_model
    from robotid.validation.procedure import validate_models as validate_models
    from robotid.validation.procedure import validate_record as validate_record
    from robotid.validation.results import ModelValidation as ModelValidation
    from robotid.validation.results import RecordValidation as RecordValidation
    from robotid.validation.results import Validation as Validation

_HOMES = {
    "ModelValidation": "results",
    "RecordValidation": "results",
    "Validation": "results",
    "ValidationOptions": "procedure",
    "initial_name": "procedure",
    "validate_model": "procedure",
    "validate_models": "procedure",
    "validate_record": "procedure",
}
"""Where each name is, below this package. It is imported when it is first used: who only reads results needs none of
the functions that make them."""

__all__ = [*_HOMES]

__getattr__ = on_first_use(__name__, _HOMES)
