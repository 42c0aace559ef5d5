"""A candidate: a motion that almost arrives, for refinement."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.motion.blocks import Block


@frozen_dataclass(eq=False)
class Candidate:
    """A motion that almost arrives; its strokes are made when they are asked for.

    Attributes:
        words: What it is made of.
        estimate_rad: About its joint travel, or what it spends in the same units [rad].
        make: Makes its strokes.
        astray: Whether it misses by so much that it may not arrive.
    """

    words: str
    estimate_rad: float
    make: Callable[[], tuple[Block, ...]]
    astray: bool = False

    @classmethod
    def of(cls, words: str, blocks: tuple[Block, ...]) -> Candidate:
        """Return the candidate whose strokes are known."""
        return cls(words, joint_travel_rad(blocks), functools.partial(tuple, blocks))

    def made(self) -> Candidate:
        """Return the candidate with its strokes made, so that the estimate is their joint travel."""
        return dataclasses.replace(Candidate.of(self.words, self.make()), astray=self.astray)


def joint_travel_rad(blocks: tuple[Block, ...]) -> float:
    """Return the joint travel of strokes [rad]."""
    return sum(b.joint_travel_rad for b in blocks)


def primitives_of(blocks: tuple[Block, ...]) -> int:
    """Return how many primitives or moves strokes are played by."""
    return sum(b.cycles * len(b.sequence) for b in blocks)
