"""The torque of a chain's axes as a linear function of the links' inertial parameters, for all samples at once.

With motion of a link in its own frame (angular speed w, angular acceleration dw, acceleration a of the origin less
gravity), Newton's and Euler's equations about the origin are linear in its mass m, first moment h = m c and inertia I:

    force  = m a + dw x h + w x (w x h)
    moment = I dw + w x (I w) + h x a

By virtual work an axis feels each link after it through the motion that a unit speed of the axis gives that link
(Atkeson, An & Hollerbach 1986; Khalil & Dombre 2002, chapter 12).
"""

from __future__ import annotations

import numpy as np

from robotid.body.chain import PER_LINK, Chain
from robotid.model.array import Array

SLICE = 20_000  # samples at a time: bounds the memory
_TRIU = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def regressor(chain: Chain, q: Array, dq: Array, ddq: Array) -> Array:
    """Y with tau = Y pi.

    q, dq, ddq (axes, n) [rad, rad/s, rad/s2] -> (axes, 10 axes, n), parameters in the order of
    `Chain.parameter_names`.
    """
    count, n = q.shape
    found = np.zeros((count, count, len(PER_LINK), n))
    w, dw = np.zeros((3, n)), np.zeros((3, n))
    a = np.broadcast_to(-chain.gravity[:, None], (3, n))
    turning = np.zeros((count, 3, n))  # angular speed of the link for a unit speed of each axis before it
    moving = np.zeros((count, 3, n))  # speed of its origin for the same
    for j, joint in enumerate(chain.joints):
        r = joint.offset
        back = _rotation(joint.rotation, joint.axis, q[j])
        axis = joint.axis[:, None]
        a = _turn(back, a + _cross(dw, r) + _cross(w, _cross(w, r)))
        w, dw = _turn(back, w), _turn(back, dw)
        dw = dw + _cross(w, axis) * dq[j] + axis * ddq[j]
        w = w + axis * dq[j]
        if j:
            moving[:j] = _turn(back, moving[:j] + _cross(turning[:j], r))
            turning[:j] = _turn(back, turning[:j])
        turning[j] = axis
        force, moment = _wrench(w, dw, a)
        found[: j + 1, j] = np.einsum("icn,cpn->ipn", moving[: j + 1], force) + np.einsum(
            "icn,cpn->ipn", turning[: j + 1], moment
        )
    return np.asarray(found.reshape(count, count * len(PER_LINK), n))


def torques(chain: Chain, pi: Array, q: Array, dq: Array, ddq: Array) -> Array:
    """Torque that accelerates and carries the links, (axes, n) [Nm]. pi (10 axes,), motion (axes, n)."""
    found = np.empty_like(q)
    for begin in range(0, q.shape[1], SLICE):
        at = slice(begin, begin + SLICE)
        found[:, at] = np.einsum("ipn,p->in", regressor(chain, q[:, at], dq[:, at], ddq[:, at]), pi)
    return found


def own_inertia(chain: Chain, pi: Array, q: Array, axis: int) -> Array:
    """What an axis' own acceleration is multiplied by, the diagonal of the mass matrix, (n,) [kg m2]. q (axes, n)."""
    unit = np.zeros_like(q)
    unit[axis] = 1.0
    found: Array = torques(chain.weightless, pi, q, np.zeros_like(q), unit)[axis]
    return found


def _rotation(placed: Array, axis: Array, angle: Array) -> Array:
    """From the frame before a joint to that of its link, (3, 3, n): the transpose of placed exp([axis] angle)."""
    k = _skew(axis[:, None])[..., 0]
    turned = np.eye(3)[..., None] - np.sin(angle) * k[..., None] + (1 - np.cos(angle)) * (k @ k)[..., None]
    return np.asarray(np.einsum("abn,cb->acn", turned, placed))


def _turn(back: Array, vector: Array) -> Array:
    """Vectors (..., 3, n) in the next frame."""
    return np.asarray(np.einsum("abn,...bn->...an", back, vector))


def _cross(a: Array, b: Array) -> Array:
    """Cross product along the axis before the last. b : (3,) where it is constant."""
    b = b[:, None] if b.ndim == 1 else b
    return np.stack(
        [
            a[..., 1, :] * b[2] - a[..., 2, :] * b[1],
            a[..., 2, :] * b[0] - a[..., 0, :] * b[2],
            a[..., 0, :] * b[1] - a[..., 1, :] * b[0],
        ],
        axis=-2,
    )


def _skew(v: Array) -> Array:
    """Matrix of the cross product with v (3, n), (3, 3, n)."""
    zero = np.zeros(v.shape[1])
    return np.array([[zero, -v[2], v[1]], [v[2], zero, -v[0]], [-v[1], v[0], zero]])


def _inertia_columns(v: Array) -> Array:
    """L with I v = L (Ixx, Ixy, Ixz, Iyy, Iyz, Izz), (3, 6, n)."""
    columns = np.zeros((3, 6, v.shape[1]))
    for k, (i, j) in enumerate(_TRIU):
        columns[i, k] += v[j]
        if i != j:
            columns[j, k] += v[i]
    return columns


def _wrench(w: Array, dw: Array, a: Array) -> tuple[Array, Array]:
    """Force and moment about the origin of a link for a unit of each of its parameters, (3, 10, n) each."""
    n = w.shape[1]
    force, moment = np.zeros((3, len(PER_LINK), n)), np.zeros((3, len(PER_LINK), n))
    spin = _skew(w)
    force[:, 0] = a
    force[:, 1:4] = _skew(dw) + np.einsum("abn,bcn->acn", spin, spin)
    moment[:, 1:4] = -_skew(a)
    moment[:, 4:] = _inertia_columns(dw) + np.einsum("abn,bcn->acn", spin, _inertia_columns(w))
    return force, moment
