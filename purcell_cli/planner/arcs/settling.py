"""Settling: chains of loops brought to the displacements that are wanted, with as many cycles as they need.

A chain whose loops are as large as they may be and that still misses lacks a cycle; one with a cycle to spare costs
less without it. What a chain misses by then the refinement makes, but a missing cycle it cannot.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.distinct import distinct
from purcell_cli.geometry.rotations import Array
from purcell_cli.planner.arcs.chain import Chains
from purcell_cli.planner.effort import Breadth

FAR_OFF = 0.02
"""Chains that miss by more than this, measured by `Chains.settled`, are astray [L, rad]."""
_LOOSE = 1e-3
"""Chains that miss by more than this may lack a cycle: ones that do not are candidates beside them [L, rad]."""
_GROWN = 3
"""So many times chains that are astray get a cycle more of every loop that is as large as may be: on the spot by half a
turn the third arrives."""
_SETTLED = 3e-3
"""While no chain misses by less than this, in the last resort, all are made longer: what loops as large as may be lack,
no refinement can give them [L, rad]."""


@frozen_dataclass(eq=False)
class SettledChains:
    """Chains settled on displacements.

    Attributes:
        chains: The chains.
        wanted: The displacements. Shape (n, 4, 4).
        around: What is spent before and after each [rad]. Shape (n,).
        rounds: Rounds in which they settle.
        off: What each misses by (see `Chains.settled`). Shape (n,).
        spent: What is spent in all [rad]. Shape (n,).
    """

    chains: Chains
    wanted: Array
    around: Array
    rounds: int
    off: Array
    spent: Array

    @classmethod
    def of(cls, chains: Chains, wanted: Array, around: Array, rounds: int) -> SettledChains:
        """Return chains settled in so many rounds; arguments as the attributes."""
        chains, off, spent = chains.settled(wanted, rounds)
        return cls(chains, wanted, around, rounds, off, spent + around)

    def __len__(self) -> int:
        return len(self.chains)

    def __getitem__(self, some: NDArray[np.int64]) -> SettledChains:
        """Return some of them, in an order of their own."""
        parts = self.chains[some], self.wanted[some], self.around[some]
        return SettledChains(*parts, self.rounds, self.off[some], self.spent[some])

    def put(self, some: NDArray[np.int64], others: SettledChains) -> SettledChains:
        """Return them with some replaced, shape (k,), by as many others for the same displacements."""
        off, spent = self.off.copy(), self.spent.copy()
        off[some], spent[some] = others.off, others.spent
        return dataclasses.replace(self, chains=self.chains.put(some, others.chains), off=off, spent=spent)

    def longer(self, some: NDArray[np.int64], least: float = 0.0) -> SettledChains:
        """Return some of them longer (see `Chains.longer`) and settled anew."""
        chains = self.chains[some].longer(self.wanted[some], least)
        return SettledChains.of(chains, self.wanted[some], self.around[some], self.rounds)

    def grown(self) -> SettledChains:
        """Return them, those that are astray and promise to be short with more cycles of the loops that are full."""
        found = self
        for _ in range(_GROWN):
            least = np.min(found.spent[found.off <= FAR_OFF], initial=np.inf)
            straight = max(fan.straight for fan in found.chains.fans)
            promised = found.spent + found.chains.short(found.wanted) / straight
            few = np.flatnonzero((found.off > FAR_OFF) & (promised < least))
            if not len(few):
                break
            more = found.longer(few)
            gained = np.flatnonzero(more.off < found.off[few])
            if not len(gained):
                break
            found = found.put(few[gained], more[gained])
        return found

    def all_longer(self, parts: tuple[float, ...]) -> SettledChains:
        """Return them, the cycles of each grown by each of some parts in turn, while none arrives."""
        found, every = self, np.arange(len(self))
        for part in parts:
            if np.any(found.off <= _SETTLED):
                break
            more = self.longer(every, part)
            gained = np.flatnonzero(more.off < found.off)
            found = found.put(gained, more[gained])
        return found

    def shorter(self, few: NDArray[np.int64], most_off: float, times: int) -> SettledChains:
        """Return them, some with fewer cycles wherever that will do.

        Args:
            few: Which are tried. Shape (k,).
            most_off: What they may miss by then [L, rad].
            times: How many cycles each may lose.
        """
        found = self
        for _ in range(times):
            if not len(few):
                break
            chains, owner = found.chains[few].shorter()
            owner = few[owner]
            fewer = SettledChains.of(chains, self.wanted[owner], self.around[owner], self.rounds)
            gain = np.where(fewer.off <= most_off, found.spent[owner] - fewer.spent, -np.inf)
            order = np.lexsort((-np.round(gain, 9), owner))
            best = order[distinct(owner[order])[0]]  # of each chain's
            best = best[gain[best] > 0.0]
            few = owner[best]
            found = found.put(few, fewer[best])
        return found

    def tight(self, times: int) -> SettledChains:
        """Return them with as few cycles as will do to miss by little, with a cycle more where they do not."""
        found = self
        if len(wide := np.flatnonzero(found.off > _LOOSE)):
            found = found.put(wide, found.longer(wide))
        return found.shorter(np.flatnonzero(found.off <= _LOOSE), _LOOSE, times)


def settled(chains: Chains, wanted: Array, around: Array, breadth: Breadth) -> tuple[SettledChains, NDArray[np.int64]]:
    """Return chains settled on displacements, and of which chain each is: beside loose ones there are tight ones.

    Args:
        chains: The chains.
        wanted: The displacements. Shape (n, 4, 4).
        around: What is spent before and after them [rad]. Shape (n,).
        breadth: How widely to search.
    """
    begun = SettledChains.of(chains, wanted, around, breadth.rounds).grown().all_longer(breadth.longer)
    few = np.argsort(np.round(begun.spent, 9), kind="stable")[: math.ceil(0.5 * len(begun))]
    found = begun.shorter(few, FAR_OFF, breadth.shorter)
    loose = np.flatnonzero((found.off > _LOOSE) & (found.off <= FAR_OFF))
    more = begun[loose].tight(breadth.shorter)
    kept = np.flatnonzero(more.off <= _LOOSE)
    of = np.append(np.arange(len(found)), loose[kept])
    return found[of].put(np.arange(len(found), len(of)), more[kept]), of
