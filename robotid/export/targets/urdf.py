"""URDF: damping and dry friction of a joint, written into a robot description or as a piece of one."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from xml.sax.saxutils import quoteattr

from robotid.errors import ConfigError
from robotid.export.handover.elements import Element, by_port, elements
from robotid.export.handover.handed_model import HandedModel
from robotid.export.handover.rigid import as_rigid
from robotid.export.handover.target import OF_A_SIGNAL, Target, xml_comments
from robotid.model.port import Port
from robotid.numerals import plain

JOINT = re.compile(r"<joint\b(?P<head>[^>]*)>(?P<body>.*?)</joint\s*>", re.DOTALL)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
DYNAMICS = re.compile(r"<dynamics\b[^>]*?(/>|>.*?</dynamics\s*>)", re.DOTALL)
NAME = re.compile(r"""\bname\s*=\s*(?P<quote>["'])(?P<name>.*?)(?P=quote)""")


class Urdf(Target):
    """The damping and the dry friction of the joint, everything beyond the gear moving with the motor. URDF knows no
    inertia of a motor and nothing elastic; the description's links have inertias of their own, which stay."""

    name = "urdf"
    suffix = ".urdf"
    summary = "damping and friction of a URDF joint, on the joint's side of the gear"
    patches = True

    def omitted(self, model: HandedModel) -> dict[str, str]:
        known = elements(model)
        found = dict[str, str]()
        for place in model.joint.placed:
            name = place.effect
            one = known.get(name)
            if place.port in (Port.GEAR, Port.LINK) or (one is not None and one.hung):
                found[name] = "URDF has nothing elastic"
            elif one is None or one.stiffness or one.cubic or one.constant:
                found[name] = "URDF has no element of this law"
        return found | {f"{signal}.{c.name}": OF_A_SIGNAL for signal, c in model.joint.channels}

    def reduced(self, model: HandedModel, omitted: Mapping[str, str]) -> HandedModel:
        return as_rigid(model, omitted)

    def remarks(self, model: HandedModel) -> tuple[str, ...]:
        ports = by_port(list(elements(model).values()))
        motor = ports.get(Port.MOTOR, Element(Port.MOTOR)).inertia / model.joint.ratio**2
        text = (
            f"Inertia of the motor, {plain(motor, 4)} {model.unit('kg m2')} at the joint, has no place in URDF: give it"
            " to the simulator as armature or rotor inertia. What this file costs is simulated with it."
        )
        return (text,) if model.joint.masses > 1 else ()

    def text(self, model: HandedModel, comment: Sequence[str]) -> str:
        one = by_port(list(elements(model).values())).get(Port.MOTOR, Element(Port.MOTOR))
        ratio = model.joint.ratio
        dynamics = f'<dynamics damping="{one.damping / ratio**2!r}" friction="{one.friction / abs(ratio)!r}"/>'
        notes = xml_comments(comment)
        if model.patched:
            return patched(model.patched, model.joint_name, [*notes, dynamics])
        kind = "prismatic" if model.fit.structure.linear else "continuous"
        name = model.joint_name or "joint"
        lines = [
            f"<robot name={quoteattr(model.robot)}>",
            '  <link name="base"/>',
            '  <link name="arm"/>',
            f'  <joint name="{name}" type="{kind}">',
            '    <parent link="base"/>',
            '    <child link="arm"/>',
            '    <axis xyz="0 0 1"/>',
            *(f"    {line}" for line in (*notes, dynamics)),
            "  </joint>",
            "</robot>",
        ]
        return "\n".join(lines) + "\n"


def patched(text: str, name: str, lines: Sequence[str]) -> str:
    """A robot description with the lines in one of its joints, in the place of its <dynamics>, all else as it was.

    Raises ConfigError where the joint is not there, or none is named and there are several.
    """
    blank = COMMENT.sub(lambda found: " " * len(found[0]), text)
    joints = dict(_joints(blank))
    if not name and len(joints) == 1:
        name = next(iter(joints))
    if name not in joints:
        what = f'it has no joint "{name}"' if name else f"it has {len(joints)} joints"
        hint = f"--joint is one of {', '.join(joints)}" if joints else "give a robot description"
        raise ConfigError(what, where="--into", hint=hint)
    begin, end = joints[name].span("body")
    before = DYNAMICS.search(blank, begin, end)
    indent = _indent(text, begin, end)
    block = f"\n{indent}".join(lines)
    if before is not None:
        return text[: before.start()] + block + text[before.end() :]
    last = len(text[begin:end].rstrip()) + begin
    return text[:last] + f"\n{indent}{block}" + text[last:]


def _joints(text: str) -> Iterator[tuple[str, re.Match[str]]]:
    """Joints by name; what only refers to one, in a transmission or a plug-in, has no axis or links."""
    for found in JOINT.finditer(text):
        named = NAME.search(found["head"])
        if named is not None and re.search(r"\btype\s*=", found["head"]):
            yield named["name"], found


def _indent(text: str, begin: int, end: int) -> str:
    """The white space before the first element of a joint."""
    found = re.match(r"\s*\n([ \t]*)<", text[begin:end])
    return found[1] if found is not None else "    "
