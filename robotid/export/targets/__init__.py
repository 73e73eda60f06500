"""Programs that a model is handed over to, a file each: `TARGETS` by the ending of the file that they read.

Every file of this folder is one target and is known at once; `robotid.export.handover` says what a target is.
"""

from robotid.export.handover.target import Target
from robotid.model.discover import discover

TARGETS: dict[str, Target] = {one.suffix: one for one in discover(__name__, __path__, Target).values()}
