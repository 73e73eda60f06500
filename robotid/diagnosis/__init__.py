"""From residual to cause: what a fitted model gets wrong, where, and which effect it lacks.

Order of reading, each room using only those before it:

1. `noise`: the error that no model can remove, and the filter that whitens a residual of it.
2. `misfit`: the torque that is missing, and the variables of the motion that order it.
3. `refit`: a model fitted as a whole through the whitening, and measured on validation records.
4. `scoring`: what every effect of the catalogue would explain, without a refit.
5. `nonparametric`: what a torque of any shape along one variable would explain.
6. `search`: score, refit the best few, accept what carries over, and repeat.
7. `verdict`: the verdict on the model; `experiment`: what would tell two causes apart that these records do not.

`criteria` is what a user demands of a cause, `results` what a diagnosis comes to, `procedure` the whole of it.
"""

from __future__ import annotations

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.procedure import DiagnosisOptions, diagnose
from robotid.diagnosis.results import Cause, Diagnosis, Misfit, Rejected, Separation

__all__ = ["Cause", "Criteria", "Diagnosis", "DiagnosisOptions", "Misfit", "Rejected", "Separation", "diagnose"]
