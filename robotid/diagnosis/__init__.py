"""From residual to cause: what a fitted model gets wrong, where, and which effect it lacks.

Order of reading, each room using only those before it:

1. `noise`: the error that no model can remove, and the filter that whitens a residual of it.
2. `misfit`: the torque that is missing, and the variables of the motion that order it.
3. `refit`: a model fitted as a whole through the whitening, and measured on validation records.
4. `scoring`: what every effect of the catalogue would explain, without a refit.
5. `events`: what happened once in a record, and is no effect of the machine.
6. `nonparametric`: what a torque of any shape along one variable would explain.
7. `search`: score, refit the best few, accept what carries over, and repeat.
8. `verdict`: the verdict on the model; `experiment`: what would tell two causes apart that these records do not.

`criteria` is what a user demands of a cause, `results` what a diagnosis comes to, `procedure` the whole of it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from robotid.lazy import on_first_use

if TYPE_CHECKING:
    from robotid.diagnosis.criteria import Criteria as Criteria
    from robotid.diagnosis.procedure import DiagnosisOptions as DiagnosisOptions
    from robotid.diagnosis.procedure import diagnose as diagnose
    from robotid.diagnosis.results import Cause as Cause
    from robotid.diagnosis.results import Diagnosis as Diagnosis
    from robotid.diagnosis.results import Misfit as Misfit
    from robotid.diagnosis.results import Rejected as Rejected
    from robotid.diagnosis.results import Separation as Separation

_HOMES = {
    "Cause": "results",
    "Criteria": "criteria",
    "Diagnosis": "results",
    "DiagnosisOptions": "procedure",
    "Misfit": "results",
    "Rejected": "results",
    "Separation": "results",
    "diagnose": "procedure",
}
"""Where each name is, below this package. It is imported when it is first used: who only reads results needs none of
the functions that make them."""

__all__ = [*_HOMES]

__getattr__ = on_first_use(__name__, _HOMES)
