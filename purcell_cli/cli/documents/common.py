"""Parts that several documents have, and the document of a failure."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, Literal, NotRequired, TypedDict, TypeVar, cast

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

D = TypeVar("D")

Done = Annotated[Literal["done"], "that it is done"]
Error = Annotated[Literal["error"], "that it could not be done"]

Direction = Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]
"""The base's directions: along x, y, z and about them."""

Moves = Literal["x", "y", "z", "roll", "pitch", "yaw", "none"]
"""What a gait is made to do."""


class Failure(TypedDict):
    """What any command prints when it could not be carried out."""

    schema: Annotated[str, "purcell/COMMAND/1"]
    verdict: Error
    error: Annotated[str, "why, in one line: place, what was wanted and what was found"]


class LinkDragPart(TypedDict):
    """The drag of a whole link in numbers; what is left out is by the law of Cox."""

    along_n_s_per_m: NotRequired[Annotated[float, "force per speed along its axis [N s/m]"]]
    across_n_s_per_m: NotRequired[Annotated[float, "force per speed across it [N s/m]"]]
    turn_n_m_s: NotRequired[Annotated[float, "torque per rate of turning about its middle [N m s]"]]
    spin_n_m_s: NotRequired[Annotated[float, "torque per rate of spinning about its axis [N m s]"]]


class LinkSizePart(TypedDict):
    """A link's own size; what is left out is the swimmer's."""

    half_length_m: NotRequired[Annotated[float, "half its length [m]"]]
    slenderness: NotRequired[Annotated[float, "its radius over its full length"]]


class WallPart(TypedDict):
    """A plane wall without slip."""

    point_m: Annotated[list[float], "a point of it in the world [m]"]
    normal: Annotated[list[float], "its unit normal, into the fluid"]


class SwimmerPart(TypedDict):
    """The swimmer."""

    base_half_length_m: Annotated[float, "half length of the base link [m]"]
    limb_half_length_m: Annotated[float, "half length of each limb [m]"]
    slenderness: Annotated[float, "radius over full length of a link"]
    viscosity_pa_s: Annotated[float, "dynamic viscosity of the fluid [Pa s]"]
    drag_ratio: Annotated[float, "lateral over longitudinal drag"]
    max_bend_rad: Annotated[float, "how far a gait may bend a limb's axis from the base's axis [rad]"]
    joint_rate_rad_s: Annotated[float, "the rate at which one joint turns [rad/s]"]
    fluid: NotRequired[Annotated[Literal["beads"], "where links feel each other's flow"]]
    wall: NotRequired[Annotated[WallPart, "a plane wall that it swims beside"]]
    drag: NotRequired[
        Annotated[
            Literal["cylinder", "spheroid"] | dict[str, LinkDragPart],
            "the law of drag where it is not Cox's, or the drag of links in numbers",
        ]
    ]
    links: NotRequired[Annotated[dict[str, LinkSizePart], "sizes of links that differ from the first three keys"]]
    body_radius_m: NotRequired[Annotated[float, "radius of a sphere at the base's middle [m]"]]
    joints: NotRequired[Annotated[dict[str, Any], "the joints as in a swimmer's file, unless both are ball joints"]]
    joint_acceleration_rad_s2: NotRequired[Annotated[float, "how fast joints' rates change, where they do not jump"]]
    L_m: Annotated[float, "the length L: the mean half length of the links [m]"]


class DisplacementPart(TypedDict):
    """A displacement of the base, in its own frame."""

    position_m: Annotated[list[float], "x, y, z [m]"]
    psi_rad: Annotated[float, "Euler angle psi [rad]"]
    theta_rad: Annotated[float, "Euler angle theta [rad]"]
    phi_rad: Annotated[float, "Euler angle phi [rad]"]


class DeviationPart(TypedDict):
    """How far one configuration is from another."""

    position_m: Annotated[float, "distance of the base's middles [m]"]
    position_over_L: Annotated[float, "the same in units of L"]
    base_rad: Annotated[float, "angle between the base's orientations [rad]"]
    limb1_rad: Annotated[float, "angle between limb 1's orientations in the base [rad]"]
    limb2_rad: Annotated[float, "angle between limb 2's orientations in the base [rad]"]


class TolerancePart(TypedDict):
    """Deviations up to which the goal is reached."""

    position_m: Annotated[float, "of the base's position [m]"]
    angle_rad: Annotated[float, "of the base's and the limbs' orientations [rad]"]


class CertificatePart(TypedDict):
    """How the controls were re-integrated."""

    method: Annotated[Literal["extrapolation"], "the integrator: Gragg, Bulirsch and Stoer's"]
    segments: Annotated[int, "segments of constant control"]
    integrated: Annotated[int, "how many of them are distinct and were integrated"]
    bound: Annotated[TolerancePart, "by how much the re-integrated end may itself be wrong"]


def as_part(value: DataclassInstance, _kind: Callable[..., D]) -> D:
    """Return a dataclass as the part of a document that has just its fields as keys."""
    import dataclasses

    return cast(D, dataclasses.asdict(value))


def keys(kind: Any) -> tuple[str, ...]:
    """Return the keys of a document's type, in order."""
    return tuple(kind.__annotations__)
