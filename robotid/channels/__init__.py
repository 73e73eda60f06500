"""The catalogue of effects on signals: one effect, one file. `CHANNELS` finds them by itself."""

from robotid.model.channel import Channel
from robotid.model.discover import discover

CHANNELS: dict[str, Channel] = discover(__name__, __path__, Channel)
