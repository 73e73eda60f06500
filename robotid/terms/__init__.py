"""The catalogue of torques: one effect, one file, each a class derived from `Term` or `MotionTransform`.

`TERMS` finds them by itself, by name in alphabetical order. Start with `coulomb` (friction), `spring`, `hysteresis`
(with memory), `backlash` (it changes the motion of its port) and `thermal_friction` (it reads other terms).
"""

from robotid.model.discover import discover
from robotid.model.term import Term

TERMS: dict[str, Term] = discover(__name__, __path__, Term)
