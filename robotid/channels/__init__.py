"""The catalogue of effects on signals: one effect, one file, each a class derived from `Channel`.

`CHANNELS` finds them by itself, by name in alphabetical order. Start with `torque_gain`, then `torque_lag` (a filter)
and `encoder_ripple` (an effect on the measured angle).
"""

from robotid.model.channel import Channel
from robotid.model.discover import discover

CHANNELS: dict[str, Channel] = discover(__name__, __path__, Channel)
