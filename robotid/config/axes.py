"""A robot of several axes: its configuration split into that of one joint for each axis.

The split works on the tree of the text, before the schema: what an axis is checked against is the schema of one joint,
and errors keep their lines. Each axis is identified by itself, and the angles of the others are its companions.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from robotid.config.excitation import ExperimentSettings
from robotid.config.former_keys import rename_former_keys
from robotid.config.robot import RobotSettings
from robotid.config.schema import Config
from robotid.config.suggest import suggest
from robotid.config.tree import FLOAT, MAP, NULL, SEQ, STR, Document, join, path_to, place, plain
from robotid.errors import ConfigError
from robotid.model.companion import drive_of

AXES = "axes"
BODY = "body"
BESIDE = ("name", AXES, BODY)
"""Keys of the robot that stand beside its axes."""

OF_THE_ROBOT = ("robot", "records", "report")
SECTIONS = tuple(name for key, field in Config.model_fields.items() if (name := field.alias or key) not in OF_THE_ROBOT)
"""Sections that an axis may have of its own: their keys stand for those of the robot's section of that name."""

OWN = ("columns", "signals", "angle")
"""Further keys of an axis: its columns and companions, and the angle under which the other axes see it."""

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_-]*")
NEEDED = ("tau_m", "phi_m")
PLAYED = tuple(ExperimentSettings.model_fields)
"""How a reference is played, which all axes of a record have in common, whatever the kind of each."""


def has_axes(root: MappingNode) -> bool:
    """Whether a configuration is of several axes, each a mapping below `robot.axes`."""
    robot = _get(root, "robot")
    return isinstance(robot, MappingNode) and _get(robot, AXES) is not None


def axes_of(written: Mapping[str, Any]) -> tuple[str, ...]:
    """The names of the axes of a configuration that is given as mappings, none of a single joint."""
    return tuple(written["robot"].get(AXES, ()))


def split(root: MappingNode) -> dict[str, Document]:
    """The configuration of each axis of a robot, by name.

    Raises ConfigError where the robot's section, or the columns of an axis, do not allow it.
    """
    robot = _get(root, "robot")
    assert isinstance(robot, MappingNode)
    axes = _axes(robot)
    return {axis: _Splitter(root, robot, axes, axis).document() for axis in axes}


def _axes(robot: MappingNode) -> dict[str, tuple[ScalarNode, MappingNode]]:
    """Key and content of each axis by its name."""
    for key, _ in robot.value:
        if key.value not in BESIDE:
            known = key.value in RobotSettings.model_fields
            what = f"{key.value} is of one axis" if known else f'there is no key "{key.value}"'
            hint = "write it under robot.axes" if known else suggest(key.value, BESIDE)
            raise ConfigError(what, where=f"{place(key.start_mark)}  robot.{key.value}", hint=hint)
    at, axes = next((key, value) for key, value in robot.value if key.value == AXES)
    where = f"{place(at.start_mark)}  robot.{AXES}"
    if not isinstance(axes, MappingNode) or not axes.value:
        raise ConfigError("expected the axes by name", where=where, hint="such as a1: {model: ..., columns: ...}")
    for key, value in axes.value:
        where = f"{place(key.start_mark)}  robot.{AXES}.{key.value}"
        if not NAME.fullmatch(key.value):
            raise ConfigError(f'a name has letters, digits, _ and - only, found "{key.value}"', where=where)
        if not isinstance(value, MappingNode):
            raise ConfigError("expected a mapping", where=where, hint="such as {model: ..., columns: ...}")
    return {key.value: (key, value) for key, value in axes.value}


def _robot_name(robot: MappingNode) -> str:
    name = _get(robot, "name")
    if isinstance(name, ScalarNode):
        return str(name.value)
    raise ConfigError('"name" is missing', where=f"{place(robot.start_mark)}  robot")


class _Splitter:
    """Makes the configuration of one axis."""

    def __init__(
        self, root: MappingNode, robot: MappingNode, axes: Mapping[str, tuple[ScalarNode, MappingNode]], axis: str
    ) -> None:
        self.whole, self.name, self.axes, self.axis = root, _robot_name(robot), axes, axis
        self.key, self.node = axes[axis]
        self.robot = robot
        self.made: list[tuple[Node, str]] = []
        rename_former_keys(self.node)

    def document(self) -> Document:
        """The configuration of the axis."""
        pairs = [(key, self._section(key.value, value)) for key, value in self.whole.value]
        present = {key.value for key, _ in pairs}
        own = [key for key, _ in self.node.value if key.value in SECTIONS and key.value not in present]
        pairs += [(key, self._section(key.value, None)) for key in own]
        pairs = [(self._word("robot") if key.value == "robot" else key, value) for key, value in pairs]
        return Document(self._node(pairs, self.whole), self.whole, tuple(self.made))

    def _section(self, name: str, common: Node | None) -> Node:
        if name == "robot":
            return self._joint()
        if name == "plant":
            return self._plant()
        if name == "records" and isinstance(common, SequenceNode):
            records = [self._record(record) for record in common.value]
            return SequenceNode(common.tag, records, common.start_mark, common.end_mark)
        own = _get(self.node, name) if name in SECTIONS else None
        if own is None or common is None:
            found = own if common is None else common
            assert found is not None  # a section of the robot, or else of the axis
            return found
        return self._merged(common, own, self._within(name))

    def _joint(self) -> MappingNode:
        kept = [(k, v) for k, v in self.node.value if k.value not in (*OWN, *SECTIONS)]
        twice = next((k for k, _ in kept if k.value in BESIDE), None)
        if twice is not None:
            raise ConfigError(f"{twice.value} is of the robot", where=f"{place(twice.start_mark)}  {self._path()}")
        pairs = [(self._word("name"), self._word(f"{self.name}_{self.axis}")), *kept]
        if isinstance(body := _get(self.robot, BODY), MappingNode):
            pairs.append((self._word(BODY), self._body(body)))
        return self._made(pairs, self._path())

    def _body(self, body: MappingNode) -> MappingNode:
        """The body with this axis, and with the signals of all axes."""
        axes = [(self._word(axis), self._body_axis(axis)) for axis in self.axes]
        added = {"axis": self._word(self.axis), "axes": self._made(axes, "")}
        pairs = [(key, value) for key, value in body.value if key.value not in added]
        return self._made([*pairs, *((self._word(key), value) for key, value in added.items())], f"robot.{BODY}")

    def _body_axis(self, axis: str) -> MappingNode:
        names = {} if axis == self.axis else {"angle": axis, "torque": drive_of(axis)}
        pairs: list[tuple[ScalarNode, Node]] = [(self._word(key), self._word(name)) for key, name in names.items()]
        ratio = _get(self.axes[axis][1], "gear_ratio")
        return self._made([*pairs, *([(self._word("gear_ratio"), ratio)] if ratio is not None else [])], "")

    def _plant(self) -> Node:
        """The virtual robot as this axis, with the truth of the others where a body couples them."""
        whole, body = self._machine(self.axis), self._coupling
        plant = _get(self.whole, "plant")
        if body is None or not isinstance(whole, MappingNode) or not isinstance(plant, MappingNode):
            return whole
        others = [(self._word(name), self._other(name)) for name in self.axes if name != self.axis]
        names = SequenceNode(SEQ, [self._word(name) for name in self.axes], body.start_mark, body.end_mark)
        added = {"axis": self._word(self.axis), "axes": names, "others": self._made(others, "")}
        pairs = [(key, value) for key, value in body.value if key.value not in added]
        pairs += [(self._word(key), value) for key, value in added.items()]
        for axis in self.axes:
            self._require_turning(axis)
        return self._made([*whole.value, (_key(plant, BODY), self._made(pairs, f"plant.{BODY}"))], "plant")

    @property
    def _coupling(self) -> MappingNode | None:
        """What couples the axes of the virtual robot."""
        plant = _get(self.whole, "plant")
        body = _get(plant, BODY) if isinstance(plant, MappingNode) else None
        return body if isinstance(body, MappingNode) else None

    def _machine(self, axis: str) -> Node:
        """The plant of an axis, its own keys over the common ones, without the body. Raises ConfigError."""
        common, own = _get(self.whole, "plant"), _get(self.axes[axis][1], "plant")
        if isinstance(own, MappingNode) and (body := _get(own, BODY)) is not None:
            where = f"{place(body.start_mark)}  {self._path(axis)}.plant.{BODY}"
            raise ConfigError("the body couples all axes", where=where, hint="write it under plant of the robot")
        if isinstance(common, MappingNode) and self._coupling is not None:
            pairs = [(key, value) for key, value in common.value if key.value != BODY]
            common = self._made(pairs, "plant")
        return self._merged(common, own, self._within("plant", axis))

    def _other(self, axis: str) -> Node:
        """Another axis of the virtual robot: all that moves it."""
        machine, (_, node) = self._machine(axis), self.axes[axis]
        if not isinstance(machine, MappingNode):
            return machine
        more = {key: value for key in ("gear_ratio", "model") if (value := _get(node, key)) is not None}
        pairs = [(self._word(key), value) for key, value in more.items() if _get(machine, key) is None]
        return self._made([*machine.value, *pairs], self._within("plant", axis))

    def _require_turning(self, axis: str) -> None:
        """Raises ConfigError for an axis that is none of links that turn about their axes."""
        key, node = self.axes[axis]
        where = f"{place(key.start_mark)}  {self._path(axis)}"
        sliding = _get(node, "linear")
        if sliding is not None and plain(sliding) is True:
            raise ConfigError(f"axis {axis} slides, and the links of plant.{BODY} turn", where=where)
        if _is_null(_get(node, "gear_ratio")):
            hint = "add gear_ratio: phi_a / phi_m, 1 where there is no gear"
            raise ConfigError(f"axis {axis} has no gear_ratio, by which its link turns", where=where, hint=hint)

    def _reference(self, common: Node, axis: str) -> Node:
        """What an axis follows: its own keys over the common ones, of which one of another kind keeps those of any
        kind. Raises ConfigError."""
        axes = _get(common, AXES) if isinstance(common, MappingNode) else None
        if not isinstance(common, MappingNode) or axes is None:
            return common
        path = path_to(self.whole, common)
        where = f"{place(axes.start_mark)}  {path}.{AXES}"
        if not isinstance(axes, MappingNode):
            raise ConfigError("expected what each axis follows, by name", where=where, hint="such as a1: {peak: 10}")
        for key, _ in axes.value:
            if key.value not in self.axes:
                where = f"{place(key.start_mark)}  {path}.{AXES}"
                raise ConfigError(f'there is no axis "{key.value}"', where=where, hint=suggest(key.value, self.axes))
        own = _get(axes, axis)
        another = isinstance(own, MappingNode) and _get(own, "kind") is not None
        kept = [(k, v) for k, v in common.value if k.value != AXES and (not another or k.value in PLAYED)]
        return self._merged(self._made(kept, path), own, f"{path}.{AXES}.{axis}")

    def _excited(self, record: MappingNode) -> MappingNode:
        """A record of the virtual robot with what this axis follows, and what the others do where a body couples
        them."""
        common = _get(record, "excite")
        given: dict[str, Node] = {} if common is None else {"excite": self._reference(common, self.axis)}
        if common is not None and self._coupling is not None:
            at = _get(common, AXES) if isinstance(common, MappingNode) else None
            of_axis = {key.value: key for key, _ in at.value} if isinstance(at, MappingNode) else {}
            others = [
                (of_axis.get(name, self._word(name, common)), self._reference(common, name))
                for name in self.axes
                if name != self.axis
            ]
            given["others"] = self._made(others, path_to(self.whole, common))
        pairs = [(key, value) for key, value in record.value if key.value not in given]
        return self._node([*pairs, *((self._word(key, common), value) for key, value in given.items())], record)

    def _record(self, record: Node) -> Node:
        """A record with the columns of this axis, and the angles of the others among its signals."""
        if not isinstance(record, MappingNode):
            return record
        if _get(record, "file") is None:
            return self._excited(record)
        columns = self._columns(record, self.axis)
        others = {name: angle for name in self.axes if name != self.axis and (angle := self._angle(record, name))}
        if _get(self.robot, BODY) is not None or self._tells_axes_apart:
            others |= {drive_of(name): self._drive(record, name) for name in self.axes if name != self.axis}
        angles = self._made([(self._word(name), angle) for name, angle in others.items()], "")
        signals = self._merged(angles, self._others(_get(record, "signals")), self._within("signals"))
        signals = self._merged(signals, _get(self.node, "signals"), self._within("signals"))
        given = {"columns": columns, "signals": signals}
        pairs = [(key, value) for key, value in record.value if key.value not in given]
        pairs += [(self._word(key), value) for key, value in given.items()]
        return self._node(pairs, record)

    @property
    def _tells_axes_apart(self) -> bool:
        """Whether experiments are given, which take the torques of all axes."""
        sections = [_get(of, "init_flex") for of in (self.whole, self.node)]
        return any(isinstance(one, MappingNode) and _get(one, "experiments") is not None for one in sections)

    def _others(self, signals: Node | None) -> Node | None:
        """The signals of a record without one of the name of this axis, which is for the other axes."""
        if not isinstance(signals, MappingNode):
            return signals
        return self._made([(k, v) for k, v in signals.value if k.value != self.axis], "")

    def _columns(self, record: MappingNode, axis: str) -> Node:
        """Columns of an axis in a record: its own over those of the record. Raises ConfigError where some are missing,
        for names alone do not tell the columns of several axes apart."""
        key, node = self.axes[axis]
        own = _get(node, "columns")
        columns = self._merged(_get(record, "columns"), own, self._within("columns"))
        for signal in NEEDED:
            if _is_null(columns) or (isinstance(columns, MappingNode) and _is_null(_get(columns, signal))):
                at = own if isinstance(own, MappingNode) else key
                where = f"{place(at.start_mark)}  {self._path(axis)}.columns"
                hint = "each axis names its own, such as columns: {tau_m: torque_1, phi_m: angle_1}"
                raise ConfigError(f"axis {axis} has no column for {signal}", where=where, hint=hint)
        return columns

    def _angle(self, record: MappingNode, axis: str) -> MappingNode | None:
        """The angle of another axis behind its gear, as a companion: what the axis itself states, or the motor's angle
        times the gear ratio. None where the axis has none for others."""
        _, node = self.axes[axis]
        stated = _get(node, "angle")
        if stated is not None:
            return None if _is_null(stated) else self._companion(stated, None)
        columns, ratio = self._columns(record, axis), _get(node, "gear_ratio")
        motor = _get(columns, "phi_m") if isinstance(columns, MappingNode) else None
        known = plain(ratio) if ratio is not None else None
        factor = float(known) if isinstance(known, int | float) else None
        return None if motor is None else self._companion(motor, factor)

    def _drive(self, record: MappingNode, axis: str) -> MappingNode:
        """The motor's torque of another axis, as a companion."""
        columns = self._columns(record, axis)
        torque = _get(columns, "tau_m") if isinstance(columns, MappingNode) else None
        return self._companion(torque if torque is not None else columns, None, "drive")

    def _companion(self, column: Node, factor: float | None, kind: str = "angle") -> MappingNode:
        """A column as a companion, times a factor."""
        pairs = list(column.value) if isinstance(column, MappingNode) else [(self._word("name"), column)]
        if factor is not None:
            numbers = {key.value: plain(value) for key, value in pairs if key.value in ("scale", "offset")}
            known = {"scale": 1.0} | {key: float(n) for key, n in numbers.items() if isinstance(n, int | float)}
            pairs = [(key, value) for key, value in pairs if key.value not in known]
            pairs += [(self._word(key), self._number(factor * number)) for key, number in known.items()]
        return self._made([*pairs, (self._word("kind"), self._word(kind))], "")

    def _merged(self, common: Node | None, own: Node | None, origin: str) -> Node:
        """A mapping whose own keys stand for the common ones; what is no mapping is left to the schema. origin : path
        in the text that errors name."""
        if own is None or _is_null(own):
            return self._made([], self._path()) if common is None else common
        if not isinstance(common, MappingNode) or not isinstance(own, MappingNode):
            return own
        replaced = {key.value for key, _ in own.value}
        pairs = [(key, value) for key, value in common.value if key.value not in replaced]
        return self._made([*pairs, *own.value], origin)

    def _made(self, pairs: Sequence[tuple[ScalarNode, Node]], origin: str) -> MappingNode:
        made = MappingNode(MAP, list(pairs), self.key.start_mark, self.key.end_mark)
        self.made.append((made, origin))
        return made

    def _node(self, pairs: list[tuple[ScalarNode, Node]], like: Node) -> MappingNode:
        return MappingNode(MAP, pairs, like.start_mark, like.end_mark)

    def _path(self, axis: str | None = None) -> str:
        return f"robot.{AXES}.{axis or self.axis}"

    def _within(self, name: str, axis: str | None = None) -> str:
        return join(self._path(axis), name)

    def _word(self, text: str, at: Node | None = None) -> ScalarNode:
        place = at or self.key
        return ScalarNode(STR, text, place.start_mark, place.end_mark)

    def _number(self, value: float) -> ScalarNode:
        return ScalarNode(FLOAT, repr(value), self.key.start_mark, self.key.end_mark)


def _get(mapping: MappingNode, key: str) -> Node | None:
    return next((value for name, value in mapping.value if name.value == key), None)


def _key(mapping: MappingNode, key: str) -> ScalarNode:
    found: ScalarNode = next(name for name, _ in mapping.value if name.value == key)
    return found


def _is_null(node: Node | None) -> bool:
    return node is None or node.tag == NULL
