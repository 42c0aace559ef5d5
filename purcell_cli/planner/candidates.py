"""Candidates: sequences of strokes that may take the swimmer to its goal at little cost.

Phases 1 and 3 move the base, so they decide which displacement is left for phase 2. Needle steering
chooses arcs and rolls for it, and a chain of loops makes them. A sequence of stored gaits or a plan of
the motion library, repeated, may be shorter. All are priced; what is dear is made only where its price
is not far above the best that is known, or where that does not arrive. Candidates miss their goal by a
few per cent; refinement removes that.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from purcell_cli.errors import GaitError
from purcell_cli.planner.arcs.steered import steered_arcs
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.effort import Breadth
from purcell_cli.planner.gait_sequence import gait_sequences
from purcell_cli.planner.library.recalled import LIBRARY_PLAN, library_plans
from purcell_cli.planner.limbs.bent_loops import BENT_LOOPS, bent_loops
from purcell_cli.planner.objectives import cost
from purcell_cli.planner.problem import Problem

Generator = Callable[[Problem, Breadth, Sequence[Candidate]], Iterable[Candidate]]
"""Makes candidates for a problem, as widely as asked; it is told those that are known already."""

GENERATORS: tuple[Generator, ...] = (bent_loops, library_plans, steered_arcs, gait_sequences)
"""The generators, in the order in which they are asked: the later ones leave to be made what does not promise more."""


def generate(problem: Problem, breadth: Breadth) -> list[Candidate]:
    """Return motions that almost make a displacement between two shapes, the best first.

    Args:
        problem: The problem.
        breadth: How widely to search.

    Raises:
        GaitError: No stored gait for a motion that is needed, and no arcs are found.
    """
    found: list[Candidate] = []
    lacking: GaitError | None = None
    for generator in GENERATORS:
        try:
            found += generator(problem, breadth, found)
        except GaitError as error:
            lacking = error
    if lacking is not None and all(c.words in (LIBRARY_PLAN, BENT_LOOPS) for c in found):
        raise lacking
    return ranked(problem, found)


def ranked(problem: Problem, candidates: Iterable[Candidate]) -> list[Candidate]:
    """Return candidates, the best first: those that may not arrive last, and the cheaper before the dearer.

    The estimate says what a candidate spends of joint travel; for another objective its strokes are made.
    """
    if problem.objective == "travel":
        return sorted(candidates, key=lambda c: (c.astray, _rounded(c.estimate_rad)))
    made = [c.made() for c in candidates]
    spent = [_rounded(cost(problem.objective, problem.swimmer, c.make(), problem.start)) for c in made]
    return [made[k] for k in sorted(range(len(made)), key=lambda k: (made[k].astray, spent[k]))]


def _rounded(spent: float) -> float:
    """Return a cost to ten digits, so that rounding errors decide no order."""
    return float(f"{spent:.9e}")
