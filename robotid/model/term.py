"""The language of mechanics: a term is the torque an effect absorbs as a function of its port's motion."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import ClassVar, Self

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind, with_companion
from robotid.model.parameters import Parameter
from robotid.model.port import Port

NO_SIDES = np.zeros((0, 1))
NO_SIDES.flags.writeable = False


# Not frozen, as all that is made afresh in every evaluation: freezing would cost a twentieth of a diagnosis.
@dataclass(slots=True)
class Motion:
    """Motion of one port over n samples.

    x position [rad], v speed [rad/s], a acceleration [rad/s2], t time in the record [s] : (n,)
    s direction of motion, sgn(v), as a variable of its own : (n,). The simulator decides it, exactly, also while
    the port sticks; abs(v) is s * v. A formula written with s is analytic in every argument.
    z the term's own states : (k, n). side : on which side of each of its edges the term is, -1 or 1 : (k, n), decided
    as s is.
    tau the torque that the term reads [Nm]; xw, vw position and speed of the port it watches : (n,), where it declares
    so. w the companion that the term reads, dw, ddw its rate and acceleration : (n,).
    """

    x: Array
    v: Array
    a: Array
    s: Array
    t: Array
    z: Array
    tau: Array | float = 0.0
    xw: Array | float = 0.0
    vw: Array | float = 0.0
    side: Array = field(default_factory=lambda: NO_SIDES)
    w: Array | float = 0.0
    dw: Array | float = 0.0
    ddw: Array | float = 0.0

    def remembering(self, z: Array, side: Array) -> Motion:
        """The same motion with a term's own states and sides. Written out, for it is made in every evaluation."""
        return Motion(
            self.x, self.v, self.a, self.s, self.t, z, self.tau, self.xw, self.vw, side, self.w, self.dw, self.ddw
        )

    def beside(self, companion: Array) -> Motion:
        """The same motion with the companion that the term reads, its rate and its acceleration, (3, n)."""
        w, dw, ddw = companion
        return Motion(self.x, self.v, self.a, self.s, self.t, self.z, self.tau, self.xw, self.vw, self.side, w, dw, ddw)

    def moved(self, x: Array, v: Array, s: Array) -> Motion:
        """The same motion at another position, speed and direction."""
        return Motion(x, v, self.a, s, self.t, self.z, self.tau, self.xw, self.vw, self.side, self.w, self.dw, self.ddw)


@dataclass(slots=True)
class Partials:
    """Derivatives of one quantity (a torque, or the rate of a state), each (n,) or a plain number.

    The plain number 0.0 says that the quantity never depends on that argument. z : one a state; theta : one a
    parameter.
    """

    x: Array | float = 0.0
    v: Array | float = 0.0
    a: Array | float = 0.0
    s: Array | float = 0.0
    z: tuple[Array | float, ...] = ()
    theta: tuple[Array | float, ...] = ()
    tau: Array | float = 0.0
    xw: Array | float = 0.0
    vw: Array | float = 0.0


@dataclass(frozen=True, slots=True)
class Reading:
    """Whose torque a term reads: the sum over all terms, or over those that are friction, at a port (None: the reader's
    own).

    It is read as it acts on the reader's coordinate: the gear's torque times the gear ratio at the motor. Terms that
    read a torque themselves, or an acceleration, are left out of the sum.
    """

    port: Port | None = None
    friction: bool = False


class Role(StrEnum):
    """What a term is to the linear skeleton of a joint. Its first parameter is then an inertia, a stiffness (of the
    nonlinear part, where the term is not linear), or a damping."""

    NONE = "none"
    MASS = "mass"
    SPRING = "spring"
    DAMPER = "damper"


@dataclass(frozen=True, slots=True)
class Extreme:
    """What an effect becomes where one of its parameters reaches a bound. parameter : its symbol; effect : name of the
    other effect, at the same port; values : of which own parameters the product becomes each of the other's, by
    symbols."""

    parameter: str
    effect: str
    values: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Oscillation:
    """A motion by which the parameters of a linear term are sized: an inertia [kg m2] that swings at the term's port
    with a frequency [rad/s] and a damping ratio."""

    inertia: float
    frequency: float
    damping_ratio: float

    @property
    def stiffness(self) -> float:
        """Of the spring on which the inertia swings so [Nm/rad]."""
        return self.frequency**2 * self.inertia

    @property
    def damping(self) -> float:
        """Of the damper that damps it so [Nm s/rad]."""
        return 2 * self.damping_ratio * self.frequency * self.inertia


class Term(ABC):
    """An effect that absorbs torque. The class body is its whole specification.

    name : as in configuration and verdicts. ports : where it may act, the usual one first. formula, source : text for
    people. signature : what the effect looks like in a residual when a model lacks it.

    The torque must be affine in a, and is written for all samples at once. states : names of a memory that evolves by
    `rate`, which may not read a, and that never passes -state_limit or state_limit once it lies between them. edges :
    names of kinks of the formula, where a `distance` changes its sign; the formula is written with m.side and is smooth
    in all else, the simulator changes sides at the very instant and takes the derivatives across. reads : a torque of
    other terms that this one depends on; the joint provides it as Motion.tau and chains its derivatives. companion :
    the kind of a further recorded signal that this one depends on; which one, an instance says that `reading` has made.

    What others must know of a term it declares itself, so that nothing outside its file names it. friction : it opposes
    the motion of surfaces that rub, so that what changes all friction changes it. linear : the torque, and the rates of
    its states, are linear in x, v, a and the states, so that it is part of a frequency response; what reads a companion
    is not. role : what it is to the skeleton of masses, springs and dampers. instead_of : a port that a joint lacks
    where the effect stands for what acts there; a joint with that port does not lack the effect. swings : it is of a
    lever that turns, which an axis that slides does not have.
    """

    name: ClassVar[str]
    ports: ClassVar[tuple[Port, ...]]
    parameters: ClassVar[tuple[Parameter, ...]]
    formula: ClassVar[str]
    source: ClassVar[str]
    signature: ClassVar[str]
    states: ClassVar[tuple[str, ...]] = ()
    state_limit: ClassVar[float] = inf
    edges: ClassVar[tuple[str, ...]] = ()
    reads: ClassVar[Reading | None] = None
    companion: ClassVar[CompanionKind | None] = None
    extremes: ClassVar[tuple[Extreme, ...]] = ()
    friction: ClassVar[bool] = False
    linear: ClassVar[bool] = False
    role: ClassVar[Role] = Role.NONE
    instead_of: ClassVar[Port | None] = None
    swings: ClassVar[bool] = False
    companion_name: str = ""

    def reading(self, companion: str) -> Self:
        """The same effect as one that reads the companion of this name, which becomes part of its own name."""
        one = copy(self)
        vars(one).update(name=with_companion(self.name, companion), companion_name=companion)
        return one

    @abstractmethod
    def torque(self, m: Motion, p: Sequence[float]) -> Array | float:
        """Absorbed torque [Nm], (n,). p : parameter values in declared order."""

    @abstractmethod
    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        """Derivatives of `torque` to everything that it reads."""

    def rate(self, m: Motion, p: Sequence[float]) -> tuple[Array | float, ...]:
        """Time derivative of each state, (n,)."""
        return ()

    def rate_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, ...]:
        """Derivatives of `rate`, one Partials a state."""
        return ()

    def distance(self, m: Motion, p: Sequence[float]) -> tuple[Array | float, ...]:
        """Distance from each edge, (n,), positive on its side 1. It may read x, v and parameters."""
        return ()

    def distance_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, ...]:
        """Derivatives of `distance`, one Partials an edge."""
        return ()

    def settled(self, m: Motion, p: Sequence[float]) -> tuple[Array | float, ...]:
        """The states after long motion as in m, (n,) each, where a record that starts amid motion finds them."""
        return (0.0,) * len(self.states)

    def sized(self, oscillation: Oscillation) -> tuple[float, ...]:
        """Values of the first parameters with which a linear term makes up its part of an oscillation at its port.

        A fit of the linear joint starts there. Empty where the term has no part in oscillations.
        """
        size = {
            Role.NONE: (),
            Role.MASS: (oscillation.inertia,),
            Role.SPRING: (oscillation.stiffness,),
            Role.DAMPER: (oscillation.damping,),
        }
        return size[self.role]


class MotionTransform(Term):
    """An effect without a torque of its own: it changes the motion that the other terms at its port act on.

    Position, speed and direction may change. watches : another port, whose motion enters as xw and vw and whose speed
    enters the new speed linearly, as that of a mechanism does: by virtual work the torques at the transformed port then
    act back on the watched one. follows : the new speed is the rate of the new position. play : the new position is
    what exceeds the first parameter on either side, and nothing below it. At its null a transform changes nothing.
    """

    watches: ClassVar[Port | None] = None
    follows: ClassVar[bool] = False
    play: ClassVar[bool] = False

    @abstractmethod
    def transform(self, m: Motion, p: Sequence[float]) -> tuple[Array, Array, Array]:
        """The position, speed and direction (x, v, s) that the other terms act on, (n,) each."""

    @abstractmethod
    def transform_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, Partials, Partials]:
        """Derivatives of position, speed and direction, in this order."""

    def torque(self, m: Motion, p: Sequence[float]) -> float:
        return 0.0

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        return Partials(z=(0.0,) * len(self.states), theta=(0.0,) * len(self.parameters))
