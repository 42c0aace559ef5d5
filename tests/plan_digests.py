"""Run as a program: plans the stored scenarios and random queries, and prints a digest of each trajectory's file.

It is started anew for each setting of the processor that `test_same_bytes` compares.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
from pathlib import Path

import numpy as np

from purcell_cli import Configuration, PlanOptions, Swimmer, load_scenario, plan, stored_scenarios, write_csv
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import from_euler

RANDOM = 20
LONG = {
    *("nearby", "planar-hinges", "planar-manoeuvre", "robot-joints", "slender", "universal-joints", "yaw-and-pitch"),
}
"""Queries whose plans take more than a second; with the effort "mixed" these are planned quickly."""


def queries() -> dict[str, tuple[Configuration, Configuration, Swimmer, dict[str, str]]]:
    """Return starts, goals, swimmers and options by name."""
    out = {}
    for name, path in stored_scenarios().items():
        scenario = load_scenario(path)
        if not scenario.mission.plain:
            continue
        out[name] = (scenario.start, scenario.goal, scenario.swimmer, {})
    start, goal, swimmer, _ = out["yaw"]
    out["yaw, least energy"] = (start, goal, swimmer, {"objective": "energy"})
    start, goal, swimmer, _ = out["along-x"]
    out["along-x, simultaneous"] = (start, goal, swimmer, {"controls": "simultaneous"})
    rng = np.random.default_rng(20)
    for k in range(RANDOM):
        swimmer = Swimmer() if k % 2 else Swimmer(limb_half_length_m=rng.uniform(0.06, 0.15), max_bend_rad=1.2)
        size = swimmer.length_m * 10.0 ** rng.uniform(-0.3, 2.0)
        bent = 0.0 if k % 3 else 0.6

        def shape(bend: float = bent) -> np.ndarray:
            return np.stack([from_euler(rng.uniform(-bend, bend, 3)) for _ in range(2)])

        pose = se3.pose(from_euler(rng.uniform(-1.5, 1.5, 3)), size * rng.uniform(-1.0, 1.0, 3))
        out[f"random {k}"] = (Configuration(shape=shape()), Configuration(pose, shape()), swimmer, {})
    return out


def main(effort: str) -> None:
    """Print a JSON object of digests by query."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "trajectory.csv"
        for name, (start, goal, swimmer, options) in queries().items():
            asked = effort if effort != "mixed" else "quick" if name in LONG else "standard"
            write_csv(plan(start, goal, swimmer=swimmer, options=PlanOptions(**options, effort=asked)).trajectory, file)
            found[name] = hashlib.sha256(file.read_bytes()).hexdigest()
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main(*sys.argv[1:])
