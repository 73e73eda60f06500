"""The model with the effects that it lacked, fitted anew, and what that gains on records that served for no fit.

Order of reading: `results` (what an extension comes to), `task` (a fitted model with what its extension takes: records,
options, starts), `procedure` (extend it, and drop the effects that do not carry over), `gains` (what each cause of a
diagnosis gains by the same fits).
"""

from __future__ import annotations

from robotid.extension.gains import gains, with_gains
from robotid.extension.procedure import extend
from robotid.extension.results import Extension, Score
from robotid.extension.task import ExtensionTask, effects_to_add, extension_task

__all__ = ["Extension", "ExtensionTask", "Score", "effects_to_add", "extend", "extension_task", "gains", "with_gains"]
