"""The planners of the contest."""

from __future__ import annotations

import functools

from benchmarks.peers import sampling, shooting
from benchmarks.peers.processes import Planner, planned
from purcell_cli import PlanOptions, Swimmer

_BEND_RAD = Swimmer().max_bend_rad

PLANNERS: dict[str, Planner] = {
    "purcell": functools.partial(planned, PlanOptions(), _BEND_RAD),
    "purcell, thorough": functools.partial(planned, PlanOptions(effort="thorough"), _BEND_RAD),
    **{f"OMPL {name}": functools.partial(sampling.answer, name, chosen) for name, chosen in sampling.SETTINGS.items()},
    "CasADi + IPOPT": functools.partial(shooting.answer, shooting.SETTINGS),
}
