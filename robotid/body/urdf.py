"""The serial chain of a URDF file: where its axes sit, and what it knows of the masses.

Read are links, joints and inertias; shapes, limits and transmissions are not needed. Links that a fixed joint carries
are part of the link before them.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.body.chain import Chain, ChainJoint
from robotid.body.consistent import parameters_of, pseudo_inertia
from robotid.errors import ConfigError
from robotid.model.array import Array

TURNING = ("revolute", "continuous")


@dataclass(frozen=True, slots=True, eq=False)
class _Edge:
    """A joint of the file: its placement in the parent link, and the direction of its axis."""

    name: str
    kind: str
    parent: str
    child: str
    rotation: Array
    offset: Array
    axis: Array


def chain_of_urdf(text: str, axes: Sequence[str], gravity: Array, source: str = "urdf") -> Chain:
    """The chain of the joints named, from the base on. Links without inertia, or of no mass, are unknown.

    Raises ConfigError where the text is no URDF, or the joints are no serial chain.
    """
    edges, inertias = _parsed(text, source)
    by_child = {edge.child: edge for edge in edges}
    names = {edge.name: edge for edge in edges}
    for axis in axes:
        if axis not in names:
            known = [edge.name for edge in edges if edge.kind in TURNING]
            hint = f"it has {', '.join(known)}; name them under robot.body.joints"
            raise ConfigError(f'there is no joint "{axis}"', where=source, hint=hint)
        if names[axis].kind not in TURNING:
            raise ConfigError(f"joint {axis} is {names[axis].kind}, not revolute", where=source)
    path = _path(names[axes[-1]], by_child)
    turning = [edge.name for edge in path if edge.kind in TURNING]
    if turning != list(axes):
        what = f"the chain to {axes[-1]} turns about {', '.join(turning)}, not {', '.join(axes)}"
        raise ConfigError(what, where=source, hint="list the axes from the base on, every one of the chain")
    _require_serial(edges, path, source)
    joints, rotation, offset = [], np.eye(3), np.zeros(3)
    for edge in path:
        offset, rotation = offset + rotation @ edge.offset, rotation @ edge.rotation
        if edge.kind in TURNING:
            own = _carried(edge.child, edges, inertias)
            joints.append(ChainJoint(edge.name, rotation, offset, edge.axis, own))
            rotation, offset = np.eye(3), np.zeros(3)
    return Chain(tuple(joints), gravity)


def _parsed(text: str, source: str) -> tuple[tuple[_Edge, ...], dict[str, Array]]:
    """The joints, and the inertial parameters of each link that has some."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise ConfigError("a URDF has no document type", where=source, hint="give a plain URDF file")
    try:
        root = ET.fromstring(text)
        if root.tag != "robot":
            raise ConfigError(f"the root is <{root.tag}>, not <robot>", where=source, hint="give a URDF file")
        edges = tuple(_edge(node) for node in root.findall("joint"))
        inertias = {str(link.get("name")): own for link in root.findall("link") if (own := _inertia(link)) is not None}
    except ET.ParseError as error:
        raise ConfigError(f"this is not XML: {error}", where=source, hint="process xacro files first") from error
    except (KeyError, ValueError, AttributeError) as error:
        raise ConfigError(f"a joint or link cannot be read: {error}", where=source, hint="check the file") from error
    return edges, inertias


def _edge(node: ET.Element) -> _Edge:
    parent, child, axis = node.find("parent"), node.find("child"), node.find("axis")
    if parent is None or child is None:
        raise ValueError(f"joint {node.get('name')} has no parent or no child")
    rotation, offset = _placement(node.find("origin"))
    direction = _numbers("1 0 0" if axis is None else axis.attrib["xyz"])
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        raise ValueError(f"joint {node.get('name')} has an axis without direction")
    kind = node.attrib["type"]
    return _Edge(
        node.attrib["name"], kind, parent.attrib["link"], child.attrib["link"], rotation, offset, direction / length
    )


def _placement(origin: ET.Element | None) -> tuple[Array, Array]:
    """Rotation (3, 3) and offset (3,) of an origin; angles are roll, pitch and yaw about fixed axes."""
    given = {} if origin is None else origin.attrib
    roll, pitch, yaw = _numbers(given.get("rpy", "0 0 0"))
    return _about(2, yaw) @ _about(1, pitch) @ _about(0, roll), _numbers(given.get("xyz", "0 0 0"))


def _numbers(text: str) -> Array:
    found = np.array([float(word) for word in text.split()])
    if found.shape != (3,) or not np.all(np.isfinite(found)):
        raise ValueError(f'expected three numbers, found "{text}"')
    return found


def _about(k: int, angle: float) -> Array:
    i, j = (k + 1) % 3, (k + 2) % 3
    rotation = np.eye(3)
    rotation[i, i] = rotation[j, j] = np.cos(angle)
    rotation[j, i] = np.sin(angle)
    rotation[i, j] = -rotation[j, i]
    return rotation


def _inertia(link: ET.Element) -> Array | None:
    """Ten parameters in the frame of the link, None where it has none."""
    inertial = link.find("inertial")
    if inertial is None:
        return None
    mass = float(inertial.find("mass").attrib["value"])  # type: ignore[union-attr]
    if mass <= 0.0:
        return None
    given = inertial.find("inertia")
    values = {} if given is None else {key: float(value) for key, value in given.attrib.items()}
    xx, xy, xz, yy, yz, zz = (values.get(key, 0.0) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
    about_centre = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    rotation, centre = _placement(inertial.find("origin"))
    turned = rotation @ about_centre @ rotation.T
    moments = np.trace(turned) / 2 * np.eye(3) - turned
    pseudo = np.zeros((4, 4))
    pseudo[:3, :3] = moments + mass * np.outer(centre, centre)
    pseudo[:3, 3] = pseudo[3, :3] = mass * centre
    pseudo[3, 3] = mass
    return parameters_of(pseudo)


def _path(last: _Edge, by_child: dict[str, _Edge]) -> list[_Edge]:
    """The joints from the base to the last one."""
    path = [last]
    while (before := by_child.get(path[-1].parent)) is not None and before not in path:
        path.append(before)
    return path[::-1]


def _require_serial(edges: Sequence[_Edge], path: Sequence[_Edge], source: str) -> None:
    """Raises ConfigError where something moves that is not part of the chain."""
    for edge in edges:
        if edge.kind != "fixed" and edge not in path:
            what = f"joint {edge.name} moves, and is not part of the chain"
            raise ConfigError(what, where=source, hint="make it fixed, or name it as an axis")


def _carried(link: str, edges: Sequence[_Edge], inertias: dict[str, Array]) -> Array | None:
    """Inertial parameters of a link with all that is fixed to it, in its frame; None where nothing of it is known."""
    own = inertias.get(link)
    for edge in edges:
        if edge.kind == "fixed" and edge.parent == link:
            carried = _carried(edge.child, edges, inertias)
            if carried is not None:
                carried = moved(carried, edge.rotation, edge.offset)
                own = carried if own is None else own + carried
    return own


def moved(parameters: Array, rotation: Array, offset: Array) -> Array:
    """Ten parameters in a frame in which their own is turned by rotation (3, 3) and at offset (3,)."""
    placed = np.eye(4)
    placed[:3, :3], placed[:3, 3] = rotation, offset
    return parameters_of(placed @ pseudo_inertia(parameters) @ placed.T)


def fixed_masses(chain: Chain) -> Chain:
    """The same chain with all known inertias as they are given, none of them estimated."""
    return replace(chain, joints=tuple(replace(j, fixed=j.inertia is not None) for j in chain.joints))
