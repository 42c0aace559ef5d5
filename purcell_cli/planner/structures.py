"""The record of structures: what the motions of a search are made of, and their joint travel."""

from __future__ import annotations

import math
from collections.abc import Sequence

from purcell_cli.motion.plan import Structure
from purcell_cli.planner.candidate import Candidate


class StructureRecord:
    """The best known joint travel of every structure.

    That is the least of the structure's motions that were brought nearly to the goal. Where there is none, it is
    that of a candidate's strokes, and where those were not made, the candidate's estimate.
    """

    def __init__(self) -> None:
        self._near: dict[str, float] = {}
        self._made: dict[Candidate, float] = {}

    def made(self, candidate: Candidate, joint_travel_rad: float) -> None:
        """Note the joint travel of a candidate's strokes [rad]."""
        self._made[candidate] = joint_travel_rad

    def near(self, words: str, joint_travel_rad: float) -> None:
        """Note the joint travel of a motion brought nearly to the goal [rad]."""
        self._near[words] = min(joint_travel_rad, self._near.get(words, math.inf))

    def structures(self, taken: Structure, candidates: Sequence[Candidate]) -> tuple[Structure, ...]:
        """Return all structures, the one taken first and the others by their joint travel.

        Args:
            taken: The structure of the plan.
            candidates: The candidates, refined or not, the best first: a structure's first counts.
        """
        known: dict[str, float] = {}
        for candidate in candidates:
            known.setdefault(candidate.words, self._made.get(candidate, candidate.estimate_rad))
        known |= self._near
        known.pop(taken.words, None)
        ranked = sorted(known.items(), key=lambda item: (round(item[1], 9), item[0]))
        return (taken, *(Structure(words, travel) for words, travel in ranked))
