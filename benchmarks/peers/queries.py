"""The queries that all planners get: seeded, in three classes from easy to hard."""

from __future__ import annotations

import dataclasses

import numpy as np

from benchmarks.random_queries import random_rotations, shape
from purcell_cli import Configuration, Swimmer
from purcell_cli.geometry import se3
from purcell_cli.mechanics.connection import COLLINEAR

CLASSES = {
    "small": "0.05 to 0.2 L and up to 15 degrees, limbs collinear at both ends",
    "near": "0.3 to 3 L, any rotation, any limbs",
    "far": "3 to 30 L, any rotation, any limbs",
}


@dataclasses.dataclass(frozen=True)
class Query:
    """One reconfiguration of the paper's swimmer.

    Attributes:
        kind: One of `CLASSES`.
        number: Which one of its class.
        swimmer: Who swims.
        start: Where it starts.
        goal: Where it is to end.
    """

    kind: str
    number: int
    swimmer: Swimmer
    start: Configuration
    goal: Configuration


def query(kind: str, number: int, seed: int) -> Query:
    """Return a numbered query of a class."""
    rng = np.random.default_rng([seed, list(CLASSES).index(kind), number])
    swimmer = Swimmer()
    low, high = {"small": (0.05, 0.2), "near": (0.3, 3.0), "far": (3.0, 30.0)}[kind]
    away = rng.normal(size=3)
    away *= low * (high / low) ** rng.random() * swimmer.length_m / np.linalg.norm(away)
    if kind == "small":
        axis = rng.normal(size=3)
        turn = se3.rotation(np.radians(rng.uniform(0.0, 15.0)) * axis / np.linalg.norm(axis))
        limbs = [COLLINEAR, COLLINEAR]
    else:
        turn = random_rotations(rng, 1)[0]
        limbs = [shape(rng, swimmer), shape(rng, swimmer)]
    start = Configuration(np.eye(4), limbs[0])
    return Query(kind, number, swimmer, start, Configuration(se3.pose(turn, away), limbs[1]))
