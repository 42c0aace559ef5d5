"""The planners, each asked one query at a time in a process of its own."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.peers.judge import LOOSE, Answer, error
from benchmarks.peers.queries import Query
from purcell_cli import plan

GRACE_S = 60.0
"""Longest that a planner may outstay its cap before its process is ended."""


def by_purcell(asked: Query, cap_s: float, _: int, effort: str = "standard") -> tuple[Answer | None, float]:
    """Return this package's plan and its time; after the cap the best so far, as Ctrl-C takes it."""
    plan(asked.start, asked.start, asked.swimmer)
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, cap_s)
    began = time.perf_counter()
    try:
        solution = plan(asked.start, asked.goal, asked.swimmer, effort=effort)
    except KeyboardInterrupt:
        return None, time.perf_counter() - began
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    took, swum = time.perf_counter() - began, solution.trajectory
    return Answer(np.diff(swum.time_s), swum.rate_rad_s[:-1]), took


def thoroughly(asked: Query, cap_s: float, seed: int) -> tuple[Answer | None, float]:
    """Return this package's plan of `--effort thorough`."""
    return by_purcell(asked, cap_s, seed, "thorough")


def by_sampling(planner: str, asked: Query, cap_s: float, seed: int) -> tuple[Answer | None, float]:
    """Return what an OMPL planner finds."""
    from benchmarks.peers.sampling import answer

    began = time.perf_counter()
    return answer(asked, planner, cap_s, seed), time.perf_counter() - began


def by_rrt(asked: Query, cap_s: float, seed: int) -> tuple[Answer | None, float]:
    """Return what OMPL's RRT finds."""
    return by_sampling("RRT", asked, cap_s, seed)


def by_kpiece(asked: Query, cap_s: float, seed: int) -> tuple[Answer | None, float]:
    """Return what OMPL's KPIECE1 finds."""
    return by_sampling("KPIECE1", asked, cap_s, seed)


def by_est(asked: Query, cap_s: float, seed: int) -> tuple[Answer | None, float]:
    """Return what OMPL's EST finds."""
    return by_sampling("EST", asked, cap_s, seed)


def by_shooting(asked: Query, cap_s: float, seed: int) -> tuple[Answer | None, float]:
    """Return the first answer of multiple shooting that arrives within the loose tolerance, or the nearest."""
    from benchmarks.peers.shooting import answers

    best, least, spent, began = None, np.inf, 0.0, time.perf_counter()
    for found in answers(asked, cap_s, seed):
        spent += time.perf_counter() - began
        off = error(asked, found)
        if off < least:
            best, least = found, off
        if off <= LOOSE:
            break
        began = time.perf_counter()  # the replay is not counted
    return best, spent


PLANNERS: dict[str, Callable[[Query, float, int], tuple[Answer | None, float]]] = {
    "purcell": by_purcell,
    "purcell, thorough": thoroughly,
    "OMPL RRT": by_rrt,
    "OMPL KPIECE1": by_kpiece,
    "OMPL EST": by_est,
    "CasADi + IPOPT": by_shooting,
}


def figures(name: str, asked: Query, cap_s: float, seed: int, out: Any) -> None:
    """Let one planner answer one query and send its figures; the process then ends without ado."""
    answer, took = PLANNERS[name](asked, cap_s, seed)
    found = {"time_s": took, "error": None, "joint_travel_rad": None, "fault": None}
    if answer is not None and len(answer.duration_s):
        found |= {"error": error(asked, answer), "joint_travel_rad": answer.joint_travel_rad}
    out.send(found)
    out.close()
    os._exit(0)  # OMPL's bindings complain of objects that are left


def outcome(name: str, asked: Query, cap_s: float, seed: int) -> dict[str, Any]:
    """Return the figures of one planner and one query, from a process of its own, and what went wrong in it."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=figures, args=(name, asked, cap_s, seed, there))
    process.start()
    there.close()
    found = {"time_s": cap_s, "error": None, "joint_travel_rad": None, "fault": "outstayed its cap"}
    if here.poll(cap_s + GRACE_S):
        try:
            found = here.recv()
        except EOFError:
            found["fault"] = "its process died"
    process.kill()
    process.join()
    return {"planner": name, "kind": asked.kind, "number": asked.number, **found}
