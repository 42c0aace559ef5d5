"""The record of structures: what the motions of a search are made of, and their joint travel."""

from __future__ import annotations

import math
from collections.abc import Sequence

from purcell_cli.motion.plan import Structure
from purcell_cli.planner.candidate import Candidate

_DEARER = {
    "travel": "takes more once it arrives exactly",
    "energy": "dissipates more energy",
    "switches": "has more primitives",
    "sensitivity": "is moved further by uncertain drag, for its joint travel",
}
"""Why a motion of less joint travel near the goal, and within limits, may be no better, by objective."""


class StructureRecord:
    """The best known joint travel of every structure.

    That is the least of the structure's motions that were brought nearly to the goal. Where there is none, it is
    that of a candidate's strokes, and where those were not made, the candidate's estimate.
    """

    def __init__(self) -> None:
        self._near: dict[str, float] = {}
        self._made: dict[Candidate, float] = {}
        self._fault: dict[str, str] = {}

    def made(self, candidate: Candidate, joint_travel_rad: float) -> None:
        """Note the joint travel of a candidate's strokes [rad]."""
        self._made[candidate] = joint_travel_rad

    def near(self, words: str, joint_travel_rad: float, fault: str = "") -> None:
        """Note the joint travel of a motion brought nearly to the goal [rad], and what kept it from being a plan."""
        if joint_travel_rad < self._near.get(words, math.inf):
            self._near[words], self._fault[words] = joint_travel_rad, fault

    def structures(
        self, taken: Structure, candidates: Sequence[Candidate], objective: str = "travel"
    ) -> tuple[Structure, ...]:
        """Return all structures, the one taken first and the others by their joint travel.

        Args:
            taken: The structure of the plan.
            candidates: The candidates, refined or not, the best first: a structure's first counts.
            objective: What the plan spends least of.
        """
        known: dict[str, float] = {}
        for candidate in candidates:
            known.setdefault(candidate.words, self._made.get(candidate, candidate.estimate_rad))
        known |= self._near
        known.pop(taken.words, None)
        ranked = sorted(known.items(), key=lambda item: (round(item[1], 9), item[0]))
        tried = {candidate.words for candidate in self._made}

        def why_not(words: str, travel: float) -> str:
            if travel >= taken.joint_travel_rad:
                return ""
            if words not in self._near:
                return "does not come near the goal" if words in tried else "was not tried: this is an estimate"
            return self._fault[words] or _DEARER[objective]

        return (taken, *(Structure(words, travel, why_not(words, travel)) for words, travel in ranked))
