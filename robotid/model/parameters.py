"""Parameters: what a term declares about a number, and the numbers of a whole model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from robotid.model.array import Array, Mask
from robotid.model.physical import Physical


@dataclass(frozen=True, slots=True)
class Parameter:
    """What an effect declares about one number of its formula.

    null is the value at which the effect vanishes (None where it never does). A parameter with a grid is a
    *shape* parameter: unidentifiable while the effect is absent, so the missing effect is scored over the grid.
    turns : it counts periods of an angle, so that records of many turns ask for points between those of any grid.
    rings : it is the frequency of a resonance [rad/s], which little damping makes narrower than the gaps of any grid.
    physical : where it makes sense; a fit that ends elsewhere imitates another effect.
    estimated : False for a number that says what the effect is, such as a count of periods that physics knows to be
    whole: fits leave it as it is. centres : it is a value of the companion about which the formula is written; the
    diagnosis takes the mean. carried : a payload adds to it. barrier : value of a shape at which the effect does what
    another one does, so that no fit gets from one side of it to the other.
    """

    symbol: str
    unit: str
    meaning: str
    guess: float
    bounds: tuple[float, float] = (-inf, inf)
    null: float | None = None
    grid: tuple[float, ...] = ()
    turns: bool = False
    rings: bool = False
    physical: Physical | None = None
    estimated: bool = True
    centres: bool = False
    carried: bool = False
    barrier: float | None = None

    @property
    def is_shape(self) -> bool:
        return bool(self.grid)


@dataclass(frozen=True, slots=True)
class KnownParameter:
    """What is known of one number before anything is estimated, in SI; what is absent is as the effect declares it.

    guess : start of the fit, before what the initialisation finds. bounds : lower and upper. fixed : it is not
    estimated, and keeps the guess or what the initialisation finds.
    """

    guess: float | None = None
    bounds: tuple[float, float] | None = None
    fixed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Parameters:
    """The numbers of a model, in the order of its effects.

    names such as "gear.spring.k1" : p; units : p; values, lower, upper : (p,); free : (p,) bool.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    lower: Array
    upper: Array
    free: Mask

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.names.index(name)])

    @property
    def by_name(self) -> dict[str, float]:
        """The values."""
        return dict(zip(self.names, self.values.tolist(), strict=True))

    @property
    def all_fixed(self) -> Parameters:
        """The same parameters, none of them free."""
        return replace(self, free=np.zeros(len(self.names), dtype=bool))

    def with_known(self, known: Mapping[str, KnownParameter]) -> Parameters:
        """The same parameters with what is known of them, by dotted name. Only a parameter that is fixed at a guess is
        not free: one that is fixed without a guess keeps what the initialisation finds. Raises KeyError for a name that
        is none of them."""
        values, free, lower, upper = self.values.copy(), self.free.copy(), self.lower.copy(), self.upper.copy()
        for name, one in known.items():
            if name not in self.names:
                raise KeyError(f"no parameter {name}")
            k = self.names.index(name)
            if one.guess is not None:
                values[k] = one.guess
                free[k] &= not one.fixed
            if one.bounds is not None:
                lower[k], upper[k] = one.bounds
        return replace(self, values=values, lower=lower, upper=upper, free=free)

    def held_at(self, values: Mapping[str, float]) -> Parameters:
        """The same parameters, those of these names fixed at these values, as far as they are among them."""
        held = {name: KnownParameter(value, fixed=True) for name, value in values.items() if name in self.names}
        return self.with_known(held)

    def taken_from(self, old: Parameters) -> Parameters:
        """The same parameters with values, bounds and freedom of those of the same name in another model."""
        fresh = {key: getattr(self, key).copy() for key in ("values", "lower", "upper", "free")}
        for k, name in enumerate(self.names):
            if name in old.names:
                i = old.names.index(name)
                for key, array in fresh.items():
                    array[k] = getattr(old, key)[i]
        return replace(self, **fresh)

    def with_values(self, values: Array | Mapping[str, float]) -> Parameters:
        """The same parameters with other values; a mapping changes the named ones only."""
        if isinstance(values, Mapping):
            unknown = set(values) - set(self.names)
            if unknown:
                raise KeyError(f"no parameter {sorted(unknown)}")
            values = np.array([values.get(n, v) for n, v in zip(self.names, self.values, strict=True)])
        return replace(self, values=np.asarray(values, dtype=np.float64))
