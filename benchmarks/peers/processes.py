"""Planners are asked one query at a time, each in a process of its own.

Caps are of processor time, and both clocks are told: wall time depends on what else the machine does.
"""

from __future__ import annotations

import dataclasses
import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.peers.judge import Answer, error
from benchmarks.peers.queries import Query
from purcell_cli import PlanOptions, plan

START_S, PATIENCE = 300.0, 10.0
"""By the wall's clock a process may take this long to start [s], and so many times its cap, before it is ended."""


def planned(options: PlanOptions, max_bend_rad: float, asked: Query, cap_s: float, _: int) -> Answer | None:
    """Return this package's plan; after the cap the best so far, as Ctrl-C takes it."""
    swimmer = dataclasses.replace(asked.swimmer, max_bend_rad=max_bend_rad)
    signal.signal(signal.SIGPROF, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_PROF, cap_s)
    try:
        swum = plan(asked.start, asked.goal, swimmer=swimmer, options=options).trajectory
    except KeyboardInterrupt:
        return None
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    return Answer(np.diff(swum.time_s), swum.rate_rad_s[:-1])


Planner = Callable[[Query, float, int], Answer | None]


def figures(planner: Planner, asked: Query, cap_s: float, seed: int, out: Any) -> None:
    """Let one planner answer one query and send its figures; the process then ends without ado."""
    plan(asked.start, asked.start, swimmer=asked.swimmer)  # everything is loaded
    wall, processor = time.perf_counter(), time.process_time()
    answer = planner(asked, cap_s, seed)
    found: dict[str, Any] = {"wall_s": time.perf_counter() - wall, "processor_s": time.process_time() - processor}
    found |= {"error": None, "joint_travel_rad": None, "duration_s": None, "fault": None}
    if answer is not None and len(answer.duration_s):
        spent = {"joint_travel_rad": answer.joint_travel_rad, "duration_s": float(np.sum(answer.duration_s))}
        found |= {"error": error(asked, answer), **spent}
    out.send(found)
    out.close()
    os._exit(0)  # OMPL's bindings complain of objects that are left


def outcome(planner: Planner, asked: Query, cap_s: float, seed: int) -> dict[str, Any]:
    """Return the figures of one planner and one query, from a process of its own, and what went wrong in it."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=figures, args=(planner, asked, cap_s, seed, there))
    process.start()
    there.close()
    patience = START_S + PATIENCE * cap_s
    found = {"wall_s": patience, "processor_s": cap_s, "error": None, "joint_travel_rad": None, "duration_s": None}
    found["fault"] = "outstayed its cap"
    if here.poll(patience):
        try:
            found = here.recv()
        except EOFError:
            found["fault"] = "its process died"
    process.kill()
    process.join()
    return {"kind": asked.kind, "number": asked.number, **found}
