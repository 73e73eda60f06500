"""The same chain in pinocchio (the extra `body`), to compare its torques with those of the regressor.

Nothing else imports pinocchio, and nothing needs it.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np

from robotid.body.chain import PER_LINK, Chain
from robotid.body.consistent import body
from robotid.body.regressor import torques
from robotid.errors import ConfigError
from robotid.model.array import Array

SAMPLES = 20
LIMIT = 1e-9  # of the largest torque


def available() -> bool:
    """Whether pinocchio is installed."""
    return find_spec("pinocchio") is not None


def model_of(chain: Chain, parameters: Array) -> Any:
    """The pinocchio model of a chain whose links have these parameters, (10 axes,)."""
    import pinocchio

    model, parent = pinocchio.Model(), 0
    model.gravity = pinocchio.Motion(np.concatenate([chain.gravity, np.zeros(3)]))
    for joint, own in zip(chain.joints, parameters.reshape(-1, len(PER_LINK)), strict=True):
        turning = pinocchio.JointModelRevoluteUnaligned(joint.axis)
        parent = model.addJoint(parent, turning, pinocchio.SE3(joint.rotation, joint.offset), joint.name)
        xx, xy, xz, yy, yz, zz = own[4:]
        # pinocchio orders the moments of inertia column by column
        own = pinocchio.Inertia.FromDynamicParameters(np.concatenate([own[:4], [xx, xy, yy, xz, yz, zz]]))
        model.appendBodyToJoint(parent, own, pinocchio.SE3.Identity())
    return model


def inverse_dynamics(chain: Chain, parameters: Array, q: Array, dq: Array, ddq: Array) -> Array:
    """Torques (axes, n) by pinocchio's recursive Newton-Euler algorithm. Motion (axes, n)."""
    import pinocchio

    model = model_of(chain, parameters)
    data = model.createData()
    found = [pinocchio.rnea(model, data, *each) for each in zip(q.T, dq.T, ddq.T, strict=True)]
    return np.stack(found, axis=1)


def difference(chain: Chain) -> float:
    """Largest difference of the regressor's torques from pinocchio's at random motions, against the largest torque."""
    random, count = np.random.default_rng(0), len(chain)
    q, dq, ddq = random.normal(size=(3, count, SAMPLES))
    centres = random.normal(size=(count, 3))
    links = np.concatenate([body(1.0 + k, centre, np.diag([0.1, 0.2, 0.3])) for k, centre in enumerate(centres)])
    expected = inverse_dynamics(chain, links, q, dq, ddq)
    return float(np.abs(torques(chain, links, q, dq, ddq) - expected).max() / np.abs(expected).max())


def require_agreement(chain: Chain) -> None:
    """Raises ConfigError where pinocchio, if it is installed, finds other torques."""
    if available() and (found := difference(chain)) > LIMIT:
        what = f"the torques of the chain differ from pinocchio's by {found:.1e} of the largest"
        raise ConfigError(what, where="robot.body", hint="report this with the description of the chain")
