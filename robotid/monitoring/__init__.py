"""An accepted model against new logs: whether it is still right, and what has changed since.

Read `results`, then `evidence` (what a log says about the parameters of a model, block by block of time), `procedure`.
"""

from robotid.monitoring.procedure import WatchOptions, watch
from robotid.monitoring.results import ParameterShift, WatchedLog, WatchResult

__all__ = ["ParameterShift", "WatchOptions", "WatchResult", "WatchedLog", "watch"]
