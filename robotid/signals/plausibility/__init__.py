"""Whether records make sense before anything is fitted to them.

Read `finding` (what a check reports), `evidence` (what the checks share), `regression` and `alignment` (how torque,
speed and angle are compared), then `checks/`, one file for each family, and `procedure`, which asks them all. A new
check is a function in one of these files, declared by `@check`.
"""

from robotid.signals.plausibility.evidence import Axis
from robotid.signals.plausibility.finding import Finding, Plausibility, Severity
from robotid.signals.plausibility.procedure import CHECKS, check_records, refuse_meaningless

__all__ = ["CHECKS", "Axis", "Finding", "Plausibility", "Severity", "check_records", "refuse_meaningless"]
