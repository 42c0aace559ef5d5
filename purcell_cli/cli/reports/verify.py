"""The verdict on a trajectory as a JSON document and as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.verdict import Verdict

if TYPE_CHECKING:
    from rich.console import Console

    from purcell_cli.verification.verify import Verification
from purcell_cli.cli.documents.plan import VerifyDocument
from purcell_cli.cli.reports.common import _checked, _deviation, _verdict, swimmer_document


def verify_document(found: Verification, swimmer: Swimmer) -> VerifyDocument:
    """Return what the check of a trajectory file found."""
    return {
        "schema": "purcell/verify/1",
        "verdict": Verdict.REACHED if found.holds else Verdict.NOT_REACHED,
        "swimmer": swimmer_document(swimmer),
        "start_error": _deviation(found.start, swimmer.length_m),
        "verified_error": _deviation(found.certificate.deviation, swimmer.length_m),
        "tolerance": {"position_m": found.certificate.tolerance_m, "angle_rad": found.certificate.tolerance_rad},
        "certificate": {
            "method": "DOP853",
            "segments": found.certificate.segments,
            "integrated": found.certificate.integrated,
        },
        "clearance_m": None if found.clearance is None else found.clearance.distance_m,
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
    if document["clearance_m"] is not None:
        console.print(f"limbs {1e3 * document['clearance_m']:.4g} mm apart or more")
    for fault in document["faults"]:
        console.print(f"- {fault}", soft_wrap=True)
    _verdict(console, document["verdict"])
