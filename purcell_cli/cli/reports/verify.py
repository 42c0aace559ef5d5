"""The verdict on a trajectory as a JSON document and as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.verdict import Verdict

if TYPE_CHECKING:
    from rich.console import Console

    from purcell_cli.verification.verify import Verification
from purcell_cli.cli.documents.common import as_part
from purcell_cli.cli.documents.plan import VerifyDocument, WorkspacePart
from purcell_cli.cli.reports.common import (
    _checked,
    _verdict,
    certificate_document,
    deviation_document,
    swimmer_document,
    turned_from_curve,
)


def verify_document(found: Verification, swimmer: Swimmer) -> VerifyDocument:
    """Return what the check of a trajectory file found."""
    limits, box = found.limits, found.limits.wanted.workspace
    return {
        "schema": "purcell/verify/1",
        "verdict": Verdict.REACHED if found.holds else Verdict.NOT_REACHED,
        "swimmer": swimmer_document(swimmer),
        "start_error": deviation_document(found.start, swimmer.length_m),
        "verified_error": deviation_document(found.certificate.deviation, swimmer.length_m),
        "tolerance": {"position_m": found.certificate.tolerance_m, "angle_rad": found.certificate.tolerance_rad},
        "certificate": certificate_document(found.certificate),
        "clearance_m": limits.clearance.distance_m,
        "largest_bend_rad": limits.largest_bend_rad,
        "workspace_violation_m": limits.workspace_violation_m,
        "obstacle_distance_m": limits.obstacle_distance_m,
        "waypoints": [
            {
                "index": one.index,
                "passed": one.met,
                "time_s": one.time_s,
                "error": deviation_document(one.off, swimmer.length_m),
            }
            for one in found.waypoints
        ],
        "follow": None
        if (follow := limits.wanted.follow) is None
        else {
            "length_m": follow.curve.length_m,
            "tolerance_m": follow.tolerance_m,
            "distance_m": limits.off_curve_m or 0.0,
            "turned_rad": limits.turned_rad,
        },
        "judged": {
            "clearance_m": limits.wanted.clearance_m,
            "max_bend_rad": swimmer.max_bend_rad,
            "workspace_m": None if box is None else as_part(box, WorkspacePart),
            "joint_rate_rad_s": [swimmer.rate_of(0), swimmer.rate_of(1)],
            "joint_acceleration_rad_s2": swimmer.joint_acceleration_rad_s2,
            "joint_ranges": not swimmer.ball_joints,
        },
        "faults": list(found.faults),
    }


def show_verify(console: Console, document: VerifyDocument) -> None:
    """Show what the check of a trajectory file found."""
    e = document["verified_error"]
    console.print(
        f"re-integrated end: position off by {e['position_over_L']:.1e} L, base {e['base_rad']:.1e} rad, "
        f"limb 1 {e['limb1_rad']:.1e} rad, limb 2 {e['limb2_rad']:.1e} rad"
    )
    _checked(console, document["certificate"])
    judged, bend = document["judged"], document["largest_bend_rad"]
    told = [f"limbs {1e3 * document['clearance_m']:.4g} mm apart or more ({1e3 * judged['clearance_m']:g} wanted)"]
    told += [] if bend is None else [f"bent {bend:.4g} rad at most in phase 2 ({judged['max_bend_rad']:g} allowed)"]
    told.append("no workspace known" if judged["workspace_m"] is None else "workspace known")
    first, second = judged["joint_rate_rad_s"]
    rates = f"{first:g}" if first == second else f"{first:g} and {second:g}"
    acceleration = judged["joint_acceleration_rad_s2"]
    ramps = "which may jump" if acceleration is None else f"accelerations {acceleration:g} rad/s^2"
    told.append(f"joint rates ({rates} rad/s allowed, {ramps})")
    told += ["axes and ranges of joints"] if judged["joint_ranges"] else []
    if (near := document["obstacle_distance_m"]) is not None:
        told.append(f"obstacles {1e3 * near:.4g} mm away or more")
    console.print("limits judged: " + ", ".join(told), soft_wrap=True)
    for one in document["waypoints"]:
        if one["passed"]:
            console.print(f"waypoint via[{one['index']}] passed at {one['time_s']:.3f} s")
    if (curve := document["follow"]) is not None:
        told_mm = f"{1e3 * curve['distance_m']:.4g} mm from the curve at most"
        allowed = f"({1e3 * curve['tolerance_m']:.4g} mm allowed)"
        console.print(f"{told_mm} {allowed}{turned_from_curve(curve['turned_rad'])}", soft_wrap=True)
    for fault in document["faults"]:
        console.print(f"- {fault}", soft_wrap=True)
    _verdict(console, document["verdict"])
