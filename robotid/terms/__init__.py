"""The catalogue of torques: one effect, one file. `TERMS` finds them by itself."""

from robotid.model.discover import discover
from robotid.model.term import Term

TERMS: dict[str, Term] = discover(__name__, __path__, Term)
