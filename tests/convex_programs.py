"""Random convex programs of blocks."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from purcell_cli.kernel.convex import Blocks, least


@dataclasses.dataclass
class Program:
    """A program with its walls as matrices."""

    blocks: Blocks
    walls: list[np.ndarray]
    bound: np.ndarray
    across: np.ndarray
    wanted: np.ndarray
    equal: int
    price: float
    begun: np.ndarray
    curve: list[np.ndarray]

    def solved(self, enough: float = 1e-8) -> np.ndarray | None:
        parts = self.bound, self.across, self.wanted, self.equal, self.price, self.begun, enough
        return least(self.blocks, *parts)

    @functools.cached_property
    def wall(self) -> np.ndarray:
        """All walls in all variables."""
        out, column, row = np.zeros((len(self.bound), len(self.begun))), 0, 0
        for wall in self.walls:
            out[row : row + len(wall), column : column + wall.shape[1]] = wall
            row, column = row + len(wall), column + wall.shape[1]
        return out

    @functools.cached_property
    def rows(self) -> np.ndarray:
        """What the rows across blocks are of all variables. Shape (m, n)."""
        out, column, first = np.zeros((len(self.wanted), len(self.begun))), 0, 0
        for size, linked, _ in self.blocks.sizes.tolist():
            out[:, column + size - linked : column + size] = self.across[first : first + linked].T
            column, first = column + size, first + linked
        return out

    def cost(self, y: np.ndarray) -> float:
        off = self.rows @ y - self.wanted
        off[: self.equal] = np.abs(off[: self.equal])
        total = self.blocks.cost @ y + self.price * np.sum(np.maximum(off, 0.0))
        first = 0
        for curve in self.curve:
            part = y[first : first + len(curve)]
            total += 0.5 * part @ curve @ part
            first += len(curve)
        return float(total)


def random_program(seed: int, curved: bool = False) -> Program:
    """Return a random program whose blocks are bounded on all sides, and whose begin is strictly within."""
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 7, rng.integers(1, 12))
    linked = [int(rng.integers(0, n + 1)) for n in sizes]
    walls = [np.concatenate([np.eye(n), -np.eye(n), rng.normal(size=(int(rng.integers(0, 4)), n))]) for n in sizes]
    begun = rng.normal(size=int(sizes.sum()))
    values = np.concatenate([w @ y for w, y in zip(walls, np.split(begun, np.cumsum(sizes)[:-1]), strict=True)])
    bound = values + rng.uniform(0.01, 1.0, len(values))
    m, equal = int(rng.integers(0, 15)), int(rng.integers(0, 4))
    equal = min(equal, m)
    across = rng.normal(size=(sum(linked), m))
    curve = []
    for n in sizes if curved else ():
        half = rng.normal(size=(n, n))
        curve.append(half @ half.T)
    flat = np.concatenate([c.ravel() for c in curve]) if curved else None
    blocks = Blocks.of(walls, linked, rng.normal(size=len(begun)), flat)
    return Program(blocks, walls, bound, across, rng.normal(size=m), equal, 10.0 ** rng.uniform(0, 2), begun, curve)
