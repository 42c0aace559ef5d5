"""The swimmer as URDF, the robot description of ROS: three cylinders, and each limb's joint as hinges.

The root link is the base link, its frame that of `rotations`: a simulator or tf hangs it into the world. A limb's frame
is at its joint, its x along the base's where the limbs are collinear, so that limb 2 lies along its own -x. Hinges
follow one another through links without shape or mass. No link has an inertia, since the model has none.
"""

from __future__ import annotations

import math
from typing import IO
from xml.etree import ElementTree as ET

from purcell_cli.files.servo_map_file import ServoMap
from purcell_cli.mechanics.hinge_chain import HingeChain
from purcell_cli.mechanics.swimmer import Swimmer

LINKS = ("base", "limb1", "limb2")
"""The links that are there, which are frames in tf too."""

_COLOURS = ("0.133 0.133 0.133 1", "0 0.447 0.698 1", "0.835 0.369 0 1")
"""The links' colours, as in the pictures: red, green, blue and opacity."""

_EFFORT = 1000.0
"""The torque that URDF wants of a hinge, at most [N m]: the model has no limit, and this is none."""


def joint_m(swimmer: Swimmer, limb: int) -> float:
    """Return where on the base's x axis a limb's joint is [m]."""
    return swimmer.base_half_length_m if limb == 1 else -swimmer.base_half_length_m


def write_urdf(swimmer: Swimmer, servo_map: ServoMap, stream: IO[bytes]) -> tuple[str, ...]:
    """Write the swimmer as URDF.

    Args:
        swimmer: The swimmer, for its lengths and radii.
        servo_map: The hinges, and how far they turn.
        stream: Where to write.

    Returns:
        The names of its joints.
    """
    robot = ET.Element("robot", name="purcell")
    for name, colour in zip(LINKS, _COLOURS, strict=True):
        ET.SubElement(ET.SubElement(robot, "material", name=f"{name}_colour"), "color", rgba=colour)
    base = _link(robot, "base", swimmer.halves_m[0], swimmer.radii_m[0], 0.0)
    if swimmer.body_radius_m:
        _body(base, swimmer.body_radius_m)
    for chain in servo_map.chains:
        _limb(robot, swimmer, servo_map, chain)
    ET.indent(robot)
    stream.write(ET.tostring(robot, encoding="utf-8", xml_declaration=True) + b"\n")
    return tuple(servo_map.channels)


def _limb(robot: ET.Element, swimmer: Swimmer, servo_map: ServoMap, chain: HingeChain) -> None:
    """Add a limb's hinges and links."""
    half, radius, limb = swimmer.halves_m[chain.limb], swimmer.radii_m[chain.limb], f"limb{chain.limb}"
    fastest, kind = swimmer.rate_of(chain.limb - 1), swimmer.joints[chain.limb - 1]
    if kind.ball or chain != ServoMap.of_swimmer(swimmer).chains[chain.limb - 1]:
        # A hinge in place of a ball turns faster than the limb, most where it is as near to its lock as the map allows.
        fastest *= math.sqrt(3.0) / math.sin(servo_map.lock_margin_rad)
    parent, at = "base", joint_m(swimmer, chain.limb)
    for k, (axis, name) in enumerate(zip(chain.order, chain.names, strict=True)):
        child = limb if k == len(chain.order) - 1 else f"{name}_link"
        joint = ET.SubElement(robot, "joint", name=name, type="revolute")
        ET.SubElement(joint, "parent", link=parent)
        ET.SubElement(joint, "child", link=child)
        ET.SubElement(joint, "origin", xyz=f"{at!r} 0 0", rpy="0 0 0")
        ET.SubElement(joint, "axis", xyz=" ".join(str(int(axis == other)) for other in "xyz"))
        low, high = servo_map.channels[name].limits_rad
        if len(chain.order) == 3 and k == 1:
            low, high = (
                max(low, servo_map.lock_margin_rad - 0.5 * math.pi),
                min(high, 0.5 * math.pi - servo_map.lock_margin_rad),
            )
        limits = {"lower": low, "upper": high, "effort": _EFFORT, "velocity": fastest}
        ET.SubElement(joint, "limit", {key: repr(value) for key, value in limits.items()})
        if child == limb:
            _link(robot, limb, half, radius, half if chain.limb == 1 else -half)
        else:
            ET.SubElement(robot, "link", name=child)
        parent, at = child, 0.0


def _body(link: ET.Element, radius: float) -> None:
    """Add the sphere at the middle of the base to its link."""
    for kind in ("visual", "collision"):
        part = ET.SubElement(link, kind)
        ET.SubElement(part, "origin", xyz="0 0 0", rpy="0 0 0")
        ET.SubElement(ET.SubElement(part, "geometry"), "sphere", radius=repr(radius))
        if kind == "visual":
            ET.SubElement(part, "material", name="base_colour")


def _link(robot: ET.Element, name: str, half_m: float, radius: float, middle_m: float) -> ET.Element:
    """Add, and return, a link that is a cylinder along its frame's x axis, its middle somewhere on that."""
    link = ET.SubElement(robot, "link", name=name)
    for kind in ("visual", "collision"):
        part = ET.SubElement(link, kind)
        ET.SubElement(part, "origin", xyz=f"{middle_m!r} 0 0", rpy=f"0 {0.5 * math.pi!r} 0")
        ET.SubElement(ET.SubElement(part, "geometry"), "cylinder", length=repr(2.0 * half_m), radius=repr(radius))
        if kind == "visual":
            ET.SubElement(part, "material", name=f"{name}_colour")
    return link
