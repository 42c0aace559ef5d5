"""How joint travel grows with distance: plans ever farther away in many directions.

    python -m benchmarks.scan --out scan.json

Limbs are straight at both ends. In each of 13 directions (the axes and diagonals up to sign) distances grow by 15 %
from 0.01 to 45 L, then rotations about the same axes from 0.01 rad to half a turn. Between neighbours joint travel
should grow by at most 30 % and fall by at most 5 %. `--every` and `--directions` thin the scan out.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import statistics
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from purcell_cli import Configuration, plan
from purcell_cli.geometry import se3

FARTHER = 1.15
"""Ratio of neighbouring distances."""
NEAREST, FARTHEST_L, FARTHEST_RAD = 0.01, 45.0, math.pi
"""The nearest of them [L or rad], and the farthest."""
MOST_GROWTH, MOST_FALL = 1.30, 0.95
"""What joint travel may grow and fall by between neighbours."""


def directions() -> list[np.ndarray]:
    """Return the axes and diagonals, one of each pair of opposite ones, as unit vectors."""
    every = [np.array(v, dtype=float) for v in itertools.product((0, 1, -1), repeat=3) if any(v)]
    return [v / np.linalg.norm(v) for v in every if v[np.flatnonzero(v)[0]] > 0.0]


def goal(direction: np.ndarray, amount: float, turning: bool) -> Configuration:
    """Return the goal that is so far away [L], or turned so far [rad], from the standard configuration."""
    twist = np.concatenate([np.zeros(3), amount * direction] if turning else [amount * direction, np.zeros(3)])
    pose = se3.exp(twist)
    pose[:3, 3] *= 0.1  # the paper's L
    return Configuration(pose)


def scanned(direction: np.ndarray, turning: bool, every: int = 1) -> Iterator[tuple[float, float, float]]:
    """Yield amounts [L or rad], the joint travel of their plans [rad], and the processor's time [s]."""
    farthest = FARTHEST_RAD if turning else FARTHEST_L
    amounts = itertools.takewhile(lambda a: a <= farthest, (NEAREST * FARTHER**k for k in itertools.count()))
    for amount in itertools.islice(amounts, 0, None, every):
        began = time.process_time()
        found = plan(Configuration(), goal(direction, amount, turning))
        if found.verdict != "reached":
            raise SystemExit(f"{found.verdict}: {direction}, {amount}")
        yield amount, found.joint_travel_rad, time.process_time() - began


def main() -> None:
    """Scan, and print where joint travel jumps."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="of the distances, only every so many")
    parser.add_argument("--directions", type=int, nargs="*", help="numbers of directions, 0 to 12")
    parser.add_argument("--out", type=Path, help="a JSON file for all figures")
    asked = parser.parse_args()
    rows = []
    ways = directions()
    most, least = MOST_GROWTH**asked.every, MOST_FALL
    plan(Configuration(), goal(ways[0], NEAREST, turning=False))
    for turning, k in itertools.product((False, True), asked.directions or range(len(ways))):
        name = f"{'about' if turning else 'along'} {np.sign(ways[k]).astype(int).tolist()}"
        found = list(scanned(ways[k], turning, asked.every))
        growth = [b[1] / a[1] for a, b in itertools.pairwise(found)]
        print(
            f"{name}: growth {min(growth):.3f} to {max(growth):.3f}, median time "
            f"{statistics.median(t for _, _, t in found):.3f} s",
            flush=True,
        )
        for (amount, travel, _), g in zip(found, growth, strict=False):
            if not least <= g <= most:
                print(f"  from {amount:.4f}, {travel:.2f} rad: {g:.3f} times", flush=True)
        rows += [(name, *one) for one in found]
    growths = [b[2] / a[2] for a, b in itertools.pairwise(rows) if a[0] == b[0]]
    kept = sum(least <= g <= most for g in growths)
    print(f"{kept} of {len(growths)} neighbours grow by at most {most - 1:.0%} and fall by at most {1 - least:.0%}")
    if asked.out:
        asked.out.write_text(json.dumps(rows))


if __name__ == "__main__":
    main()
