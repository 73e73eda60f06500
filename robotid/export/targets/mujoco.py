"""MuJoCo: the joint as MJCF, on the joint's side of the gear."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from xml.sax.saxutils import quoteattr

from robotid.export.handover.elements import Element, Hung, by_port, elements
from robotid.export.handover.handed_model import HandedModel
from robotid.export.handover.target import OF_A_SIGNAL, Target, xml_comments
from robotid.model.port import Port

TIMESTEP = 1e-3  # [s] where no record tells a sampling time
SMALLEST = 1e-9  # of the motor's inertia: what a body weighs that must weigh something
FRICTION_TIME = 2.0  # time steps within which the constraint that is dry friction settles


class Mujoco(Target):
    """Motor and twist of the gear are two hinges of one body: the first has the motor's inertia as armature, its
    damping and dry friction, the second the stiffness and damping of the gear. A tool behind an elastic link is a body
    of its own. Play is the dead band of the gear's spring, which is exact where a hinge with limits would need a mass
    of its own and soft stops. A constant torque of the motor is a bias of its actuator. What hangs elastically on the
    outermost body is the next one."""

    name = "mujoco"
    suffix = ".xml"
    summary = "MJCF for MuJoCo, on the joint's side of the gear"

    def omitted(self, model: HandedModel) -> dict[str, str]:
        known = elements(model)
        last = _hanging(model)
        known = {name: one for name, one in known.items() if not one.hung or name == last}
        why = "MJCF has no element of this law"
        names = [place.effect for place in model.joint.placed]
        missing = {name: why for name in names if name not in known}
        rigid = model.joint.masses == 1
        missing |= {name: why for name, one in known.items() if one.constant and one.port != Port.MOTOR and not rigid}
        return missing | {f"{signal}.{c.name}": OF_A_SIGNAL for signal, c in model.joint.channels}

    def remarks(self, model: HandedModel) -> tuple[str, ...]:
        ports = by_port(list(elements(model).values()))
        geared = "; angles are the joint's, the motor's times the gear ratio" if model.joint.ratio != 1.0 else ""
        found = [f"The control is the {'force' if model.fit.structure.linear else 'torque'} of the motor{geared}."]
        if any(one.constant for one in ports.values()):
            found.append("The constant part is a bias of the actuator.")
        if any(one.cubic for one in ports.values()):
            found.append("A stiffness of three numbers, which a cubic spring is, needs MuJoCo 3.8 or later.")
        if any(one.play and one.damping for one in ports.values()):
            found.append("The damper acts within the play, too.")
        return tuple(found)

    def text(self, model: HandedModel, comment: Sequence[str]) -> str:
        joint, ratio = model.joint, model.joint.ratio
        name = model.joint_name or "joint"
        ports = by_port(list(elements(model).values()))
        masses, slides = joint.masses, model.fit.structure.linear
        motor, gear, arm, link, tool = (
            ports.get(port, Element(port)) for port in (Port.MOTOR, Port.GEAR, Port.ARM, Port.LINK, Port.TOOL)
        )
        motor = _reflected(motor, ratio)
        if masses < 3:
            arm += replace(link, port=Port.ARM)
        if masses == 1:
            motor, arm = motor + replace(arm, port=Port.MOTOR), Element(Port.ARM)
        for hung in (*motor.hung, *arm.hung):
            spring = Element(Port.LINK, stiffness=hung.stiffness, damping=hung.damping)
            body = Element(Port.TOOL, inertia=hung.inertia)
            if masses == 1:
                gear, arm = replace(spring, port=Port.GEAR), replace(body, port=Port.ARM)
            else:
                link, tool = spring, body
            masses += 1
        step = min((r.sampling_time for r in model.records), default=TIMESTEP)
        kind = "slide" if slides else "hinge"
        twists = f"{name}_twist"
        lines = [
            f"<mujoco model={quoteattr(model.robot)}>",
            *(f"  {line}" for line in xml_comments(comment)),
            '  <compiler angle="radian"/>',
            f'  <option timestep="{step:.12g}" integrator="implicitfast" gravity="0 0 0"/>',
            "  <worldbody>",
            f'    <body name="{name}_arm">',
            f"      {_joint(name, kind, motor, step, armature=motor.inertia)}",
        ]
        tendons: list[str] = []
        if masses > 1:
            lines.append(f"      {_elastic(twists, kind, gear, step, tendons)}")
        least = SMALLEST * max(motor.inertia, 1e-12)
        lines.append(f"      {_inertial(max(arm.inertia, least), slides=slides)}")
        if masses > 2:
            links = f"{name}_link"
            lines.append(f'      <body name="{name}_tool">')
            lines.append(f"        {_elastic(links, kind, link, step, tendons)}")
            lines.append(f"        {_inertial(max(tool.inertia, least), slides=slides)}")
            lines.append("      </body>")
            tendons += _tendon(f"{name}_at_tool", tool, (name, twists, links), step)
        tendons += _tendon(f"{name}_at_arm", arm, (name, twists), step)
        lines += ["    </body>", "  </worldbody>"]
        if tendons:
            lines += ["  <tendon>", *(f"    {line}" for line in tendons), "  </tendon>"]
        lines += [
            "  <actuator>",
            f"    {_actuator(name, ratio, motor.constant)}",
            "  </actuator>",
            "</mujoco>",
        ]
        return "\n".join(lines) + "\n"


def _hanging(model: HandedModel) -> str:
    """The effect by which something hangs on the outermost body and on nothing else, empty where none does."""
    outermost = {1: tuple(Port), 2: (Port.ARM, Port.LINK)}.get(model.joint.masses, ())
    hung = {name: one.port for name, one in elements(model).items() if one.hung}
    return next((name for name, port in hung.items() if port in outermost), "") if len(hung) == 1 else ""


def _reflected(one: Element, ratio: float) -> Element:
    """What acts on the motor as it acts on the joint, whose angle is `ratio` times the motor's."""
    squared = ratio * ratio
    return Element(
        one.port,
        one.stiffness / squared,
        one.cubic / squared**2,
        one.damping / squared,
        one.inertia / squared,
        one.friction / abs(ratio),
        one.constant / ratio,
        hung=tuple(Hung(h.inertia / squared, h.stiffness / squared, h.damping / squared) for h in one.hung),
    )


def _actuator(name: str, ratio: float, constant: float) -> str:
    """The motor; constant : what the joint absorbs all the time [Nm], on its own side."""
    driven = f'name="{name}" joint="{name}" gear="{1.0 / ratio!r}"'
    if not constant:
        return f"<motor {driven}/>"
    return f'<general {driven} gaintype="fixed" gainprm="1" biastype="affine" biasprm="{-constant * ratio!r} 0 0"/>'


def _joint(name: str, kind: str, one: Element, step: float, armature: float = 0.0) -> str:
    attributes = f' armature="{armature!r}"' if armature else ""
    return f'<joint name="{name}" type="{kind}" axis="0 0 1"{attributes}{_passive(one, step)}/>'


def _elastic(name: str, kind: str, one: Element, step: float, tendons: list[str]) -> str:
    """The joint of something that bends; where it has play, its spring is a tendon with a dead band."""
    if not one.play:
        return _joint(name, kind, one, step)
    tendons += _tendon(f"{name}_spring", replace(one, damping=0.0, friction=0.0), (name,), step)
    return _joint(name, kind, replace(one, stiffness=0.0, cubic=0.0), step)


def _tendon(name: str, one: Element, joints: Sequence[str], step: float) -> list[str]:
    """What acts on the sum of several joints, nothing where that is nothing."""
    if not (one.stiffness or one.cubic or one.damping or one.friction):
        return []
    band = f"{-one.play!r} {one.play!r}" if one.play else "0 0"
    rest = f' springlength="{band}"' if one.stiffness or one.cubic else ""
    return [
        f'<fixed name="{name}"{_passive(one, step)}{rest}>',
        *(f'  <joint joint="{joint}" coef="1"/>' for joint in joints),
        "</fixed>",
    ]


def _passive(one: Element, step: float) -> str:
    """Attributes of stiffness, damping and dry friction."""
    text = ""
    if one.cubic:
        text += f' stiffness="{one.stiffness!r} 0 {one.cubic!r}"'
    elif one.stiffness:
        text += f' stiffness="{one.stiffness!r}"'
    if one.damping:
        text += f' damping="{one.damping!r}"'
    if one.friction:
        text += f' frictionloss="{one.friction!r}" solreffriction="{FRICTION_TIME * step:.12g} 1"'
    return text


def _inertial(inertia: float, *, slides: bool) -> str:
    mass = repr(inertia) if slides else "1"
    return f'<inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>'
