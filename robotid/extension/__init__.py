"""The model with the effects that it lacked, fitted anew, and what that gains on records that served for no fit.

Order of reading: `results` (what an extension comes to), `task` (a fitted model with what its extension takes: records,
options, starts), `procedure` (extend it, and drop the effects that do not carry over), `gain_by_cause` (what each
cause of a diagnosis gains by the same fits).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from robotid.lazy import on_first_use

if TYPE_CHECKING:
    from robotid.extension.gain_by_cause import diagnose_with_gains as diagnose_with_gains
    from robotid.extension.gain_by_cause import gains as gains
    from robotid.extension.gain_by_cause import with_gains as with_gains
    from robotid.extension.procedure import extend as extend
    from robotid.extension.results import Extension as Extension
    from robotid.extension.results import Score as Score
    from robotid.extension.task import ExtensionTask as ExtensionTask
    from robotid.extension.task import corrected as corrected
    from robotid.extension.task import effects_to_add as effects_to_add
    from robotid.extension.task import extension_task as extension_task

_HOMES = {
    "Extension": "results",
    "ExtensionTask": "task",
    "Score": "results",
    "corrected": "task",
    "diagnose_with_gains": "gain_by_cause",
    "effects_to_add": "task",
    "extend": "procedure",
    "extension_task": "task",
    "gains": "gain_by_cause",
    "with_gains": "gain_by_cause",
}
"""Where each name is, below this package. It is imported when it is first used: who only reads results needs none of
the functions that make them."""

__all__ = [*_HOMES]

__getattr__ = on_first_use(__name__, _HOMES)
