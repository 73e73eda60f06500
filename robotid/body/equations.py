"""The torques of all axes as one set of linear equations: bodies, rotors and friction side by side.

    tau_i = Y_i(q, dq, ddq) pi + J_i ddq_i + Fv_i dq_i + Fc_i sgn(dq_i) + Fa_i abs(dq_i) + offset_i

with J_i the inertia of the rotor behind its gear, and of the friction what is wanted. All torques and angles are those
of the axis behind its gear.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.body.chain import PER_LINK, Chain
from robotid.body.regressor import regressor
from robotid.model.array import Array

ROTOR = "J"
FRICTION = {"viscous": "Fv", "coulomb": "Fc", "asymmetric": "Fa", "offset": "offset"}
"""Symbols of what else a drive may have: viscous friction, dry friction, what is added to the viscous friction in one
direction and taken from it in the other, constant torque."""

USUAL_FRICTION = ("viscous", "coulomb", "offset")

UNITS = {
    **dict.fromkeys((*PER_LINK[4:], "J"), "kg m2"),
    **dict.fromkeys(PER_LINK[1:4], "kg m"),
    "m": "kg",
    "Fv": "Nm s/rad",
    "Fa": "Nm s/rad",
    "Fc": "Nm",
    "offset": "Nm",
}


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A record as the regression sees it: filtered and decimated, (axes, n) each.

    q, dq, ddq [rad, rad/s, rad/s2]; direction : sgn of the speed, filtered as the torque is; torque [Nm]. fitted :
    whether parameters are estimated from it.
    """

    name: str
    q: Array
    dq: Array
    ddq: Array
    direction: Array
    torque: Array
    fitted: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """What the torque is made of. friction : keys of `FRICTION`, of every drive."""

    chain: Chain
    friction: tuple[str, ...] = USUAL_FRICTION

    @property
    def drive(self) -> tuple[str, ...]:
        """Symbols of a drive's unknowns."""
        return (ROTOR, *(FRICTION[one] for one in self.friction))

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of all unknowns, in the order of `columns`: links first, then each of `drive` for every axis."""
        names = self.chain.names
        return (*self.chain.parameter_names, *(f"{name}.{symbol}" for symbol in self.drive for name in names))


def unit_of(symbol: str) -> str:
    """Of an unknown."""
    return UNITS[symbol.rpartition(".")[2]]


def columns(structure: Structure, motion: Motion) -> Array:
    """What each unknown adds to the torque of each axis, (axes, unknowns, n)."""
    count, n = motion.q.shape
    of_drives = {
        ROTOR: motion.ddq,
        FRICTION["viscous"]: motion.dq,
        FRICTION["coulomb"]: motion.direction,
        FRICTION["asymmetric"]: np.abs(motion.dq),
        FRICTION["offset"]: np.ones_like(motion.q),
    }
    drives = np.zeros((count, len(structure.drive), count, n))
    axes = np.arange(count)
    for k, symbol in enumerate(structure.drive):
        drives[axes, k, axes] = of_drives[symbol]
    links = regressor(structure.chain, motion.q, motion.dq, motion.ddq)
    return np.concatenate([links, drives.reshape(count, -1, n)], axis=1)


def stacked(blocks: Sequence[Array]) -> Array:
    """Columns (axes, unknowns, n) of several records as rows, (axes times all n, unknowns)."""
    return np.concatenate([np.moveaxis(block, 1, 2).reshape(-1, block.shape[1]) for block in blocks])
