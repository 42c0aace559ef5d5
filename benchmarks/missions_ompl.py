"""OMPL's control planners among obstacles, with the model and the settings that they have in empty water.

Like all of OMPL's they look at the states after each step of 0.1 s, in which a link's end moves by up to 0.1 L;
distances are this package's own, compiled. Each is asked in a process of its own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.missions_worlds import SWIMMER
from benchmarks.peers import processes
from benchmarks.peers.judge import Answer
from benchmarks.peers.queries import Query
from benchmarks.resumed import Row
from purcell_cli import Configuration
from purcell_cli.environment.scene import Scene
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import from_quaternion
from purcell_cli.motion.obstacle_distance import link_radii, link_segments


def asked_of(planner: str, scene: Scene, start: Configuration, goal: Configuration, cap_s: float, seed: int) -> Row:
    """Return how far from the goal a planner ends, and what that took, from a process of its own.

    Args:
        planner: RRT, KPIECE1 or EST.
        scene: The obstacles.
        start: The start configuration.
        goal: The goal configuration.
        cap_s: The processor time it has [s].
        seed: Of OMPL's random numbers.
    """
    moved = Configuration(se3.normalised(se3.inverse(start.pose) @ goal.pose), goal.shape)
    query = Query("far", seed, SWIMMER, Configuration(np.eye(4), start.shape), moved)
    return processes.outcome(functools.partial(among, planner, scene, start.pose), query, cap_s, seed)


def among(planner: str, scene: Scene, world: np.ndarray, query: Query, cap_s: float, seed: int) -> Answer | None:
    """Return what a planner finds among obstacles, seen from the start's pose (4, 4) in the world [m]."""
    from benchmarks.peers import sampling

    return sampling.answer(planner, sampling.SETTINGS[planner], query, cap_s, seed, clear_of(scene, world))


def clear_of(scene: Scene, world: np.ndarray) -> Callable[[Any], bool]:
    """Return a check whether all links of a state are clear of obstacles."""
    from benchmarks.peers.sampling import read

    radii = link_radii(SWIMMER)

    def clear(state: Any) -> bool:
        x = np.array(read(state))
        turns = from_quaternion(x[3:].reshape(3, 4))
        pose = world @ se3.pose(turns[0], x[:3] * SWIMMER.length_m)
        first, last = link_segments(SWIMMER, pose[None], turns[None, 1:, :, 0])
        return bool(np.all(scene.distance(first[0], last[0])[0] > radii))

    return clear
