"""Attacks on the program, with random numbers: what must never happen is counted.

    python benchmarks/adversary.py --count 300

Plans: random swimmers for which plans are promised (docs/explanation/cannot.md), and random queries for them. A plan
called reached is written, read back and replayed in extended precision, by the integrator that the planner does not
have; a plan that is not reached is counted by its verdict.
Trajectories: a number of a good file is changed, and verify must find it. Signals:
commands that write are interrupted, terminated or killed at random moments, or find a full disk or a closed pipe, and
neither a half file nor a process may be left.
Names: outputs with names that are hard for shells, patterns and markup.

Exit code 1 if anything is called what it is not, or is lost. `--seed` begins elsewhere, `--only plans` leaves the other
attacks out.
"""

from __future__ import annotations

import argparse
import dataclasses
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from purcell_cli import Configuration, PlanOptions, Swimmer, plan, read_csv, write_csv
from purcell_cli.errors import PurcellError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.geometry.rotations import from_euler
from purcell_cli.mechanics.configuration import Deviation
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.planner.arcs.primitive_counts import promised
from purcell_cli.verification.replay import replay
from purcell_cli.verification.verify import verify

sys.path.insert(0, str(Path(__file__).resolve().parent))  # where commands are interrupted
sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))  # where random swimmers are
from interrupted import PURCELL, interrupted
from joint_queries import COMBINATIONS, Query, displacement_of, joint_faults, shape_of
from random_swimmers import between, jointed, of_its_own, room

_OF_ITS_OWN = 3
"""Of so many swimmers one has drags and links of its own."""
_JOINTED = 4
"""Of so many swimmers one hangs on other joints than ball joints, with ranges, rates and ramps."""
_SIMULTANEOUS = 10
"""Of so many plans one turns all joints at once."""
NAMES = ("run[1].csv", "a b.csv", "[red]x.csv", "*.csv", "~.csv", "-x.csv", "%20.csv", "ü漢.csv", "x" * 200 + ".csv")
"""Names of files that are hard for patterns, markup, shells and other programs."""


def drawn(rng: np.random.Generator) -> Swimmer:
    """Return a random swimmer."""
    base = between(rng, 1e-4, 1.0)
    return Swimmer(
        base_half_length_m=base,
        limb_half_length_m=base * between(rng, 0.05, 20.0),
        slenderness=between(rng, 1e-4, 0.15),
        viscosity_pa_s=between(rng, 1e-3, 10.0),
        drag_ratio=float(rng.choice([1.05, 1.3, 1.6, 2.0, 3.0, 4.0])),
        max_bend_rad=between(rng, 0.05, 3.1),
        joint_rate_rad_s=between(rng, 1e-3, 1e3),
    )


def query(seed: int) -> Query:
    """Return a swimmer of the space for which plans are promised, a start and a goal."""
    rng = np.random.default_rng(seed)
    while True:
        swimmer = of_its_own(rng, drawn(rng)) if seed % _OF_ITS_OWN == 1 else drawn(rng)
        if not promised(swimmer, stored_gaits()) or room(swimmer, COLLINEAR[..., 0]) <= 0.0:
            continue  # limbs thicker than the base is long overlap at any shape
        joints = str(rng.choice(list(COMBINATIONS))) if seed % _JOINTED == 2 else ""
        if not joints:
            break
        swimmer = jointed(rng, swimmer, COMBINATIONS[joints])
        if promised(swimmer, stored_gaits()):
            break

    def limb() -> np.ndarray:
        spread = np.degrees(min(swimmer.max_bend_rad, 1.0))
        kinds = [(0.0, 0.0, 0.0), tuple(rng.uniform(-spread, spread, 3)), (0.0, 0.0, float(rng.uniform(-180.0, 180.0)))]
        return from_euler(np.radians([*kinds, tuple(rng.uniform(-90.0, 90.0, 3))][int(rng.integers(4))]))

    while True:
        first = tuple(rng.uniform(-180.0, 180.0, 3))
        here, there = (shape_of(rng, swimmer) if joints else np.stack([limb(), limb()]) for _ in range(2))
        if min(room(swimmer, c[..., 0]) for c in (here, there)) > 0.0:
            break
    start = Configuration(Configuration.from_angles((0.0, 0.0, 0.0), first).pose, here)
    away = between(rng, 1e-3, 8.0) * swimmer.length_m
    if joints:
        return Query(swimmer, start, Configuration(start.pose @ displacement_of(rng, swimmer, joints, away), there))
    way, turn = np.eye(4), rng.uniform(-1.0, 1.0, 3) * float(rng.choice([0.0, 0.1, 1.0, 3.0]))
    along = rng.normal(size=3)
    way[:3, :3] = from_euler(turn)
    way[:3, 3] = along / np.linalg.norm(along) * away
    return Query(swimmer, start, Configuration(start.pose @ way, there))


def planned(seed: int, folder: Path) -> str:
    """Return how a random plan ends, or what is wrong with it."""
    asked = query(seed)
    swimmer, start, goal = asked.swimmer, asked.start, asked.goal
    controls = "primitive" if seed % _SIMULTANEOUS or not swimmer.ball_joints else "simultaneous"
    by = "" if swimmer.ball_joints else " (other joints)"
    try:
        found = plan(start, goal, swimmer=swimmer, options=PlanOptions(effort="quick", controls=controls, dt_s=1e12))
    except PurcellError as error:
        return f"refused{by}: {str(error).partition(':')[0]}"
    if found.verdict != "reached":
        return f"{found.verdict}{by}"
    write_csv(found.trajectory, folder / "plan.csv")
    table = read_csv(folder / "plan.csv")
    end = replay(swimmer, start, table.time_s, table.rate_rad_s, tolerance_l=1e-12, tolerance_rad=1e-12).end
    off = Deviation.between(end, goal)
    if not off.within(1e-9 * swimmer.length_m, 1e-9):
        return f"WRONG: reached, but {off} away"
    if told := verify([table], start, goal, swimmer, 1e-9, 1e-9).faults:
        return f"WRONG: reached, but verify says {told[0]}"
    if told := joint_faults(asked, found.trajectory):
        return f"WRONG: reached, but {told[0]}"
    return f"reached{by}"


def tampered(table: Table, rng: np.random.Generator) -> Table:
    """Return rows of which one number is another."""
    name = str(rng.choice(["position_m", "base", "limbs", "rate_rad_s", "time_s"]))
    values = getattr(table, name).copy()
    place = (int(rng.integers(1, len(values) - 1)), *(int(rng.integers(n)) for n in values.shape[1:]))
    values[place] += between(rng, 1e-6, 1e-2) * (1.0 if name == "time_s" else float(rng.choice([-1.0, 1.0])))
    if name in {"base", "limbs"}:
        values /= np.linalg.norm(values, axis=-1, keepdims=True)
    return dataclasses.replace(table, **{name: values})


def tampering(count: int, seed: int) -> Iterator[str]:
    """Return whether verify finds changed numbers in a good file."""
    start, goal = Configuration(), Configuration.from_angles((0.02, 0.01, 0.0), (20.0, 0.0, 0.0))
    rows = plan(start, goal, options=PlanOptions(effort="quick")).trajectory
    with tempfile.TemporaryDirectory() as folder:
        write_csv(rows, Path(folder) / "good.csv")
        good = read_csv(Path(folder) / "good.csv")
    asked = (start, goal, Swimmer(), 1e-9, 1e-9)
    if verify([good], *asked).faults:
        yield "WRONG: a good file is refused"
    for k in range(count):
        found = verify([tampered(good, np.random.default_rng(seed + k))], *asked).faults
        yield "found" if found else f"WRONG: changed file {seed + k} is passed"


def named(name: str) -> str:
    """Return whether a file of a name is written, drawn and checked under just that name."""
    with tempfile.TemporaryDirectory() as folder:
        for command in (["gait", "x-motion", f"--out=./{name}"], ["view", f"./{name}", "--out=page.html"]):
            done = subprocess.run(  # noqa: S603  # this very program
                [*PURCELL, *command], cwd=folder, capture_output=True, text=True, check=False
            )
            if done.returncode or "Traceback" in done.stderr:
                return f"WRONG: {name!r}: {command[0]} ends with {done.returncode}: {done.stderr[-200:]}"
        left = sorted(path.name for path in Path(folder).iterdir())
    return "as named" if left == sorted([name, "page.html"]) else f"WRONG: {name!r} became {left}"


def main() -> int:
    """Attack, print what was found, and return the exit code."""
    options = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    options.add_argument("--count", type=int, default=300, help="random plans; of the other attacks a part of that")
    options.add_argument("--seed", type=int, default=0, help="the number of the first")
    options.add_argument("--only", choices=("plans", "tampered trajectories", "signals", "names"), help="one attack")
    asked = options.parse_args()
    few, seeds = max(asked.count // 5, 10), range(asked.seed, asked.seed + asked.count)
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        attacks = {
            "plans": (planned(seed, Path(folder)) for seed in seeds),
            "tampered trajectories": tampering(2 * few, asked.seed),
            "signals": interrupted(few, asked.seed, Path(folder)),
            "names": (named(name) for name in NAMES),
        }
        for attack, found in attacks.items():
            if asked.only not in {None, attack}:
                continue
            begun, told = time.perf_counter(), Counter[str]()
            for text in found:
                told[text] += 1
                spent = time.perf_counter() - begun
                print(
                    f"{attack}: {told.total()} from {asked.seed} on, in {spent:.0f} s: {text}",
                    file=sys.stderr,
                    flush=True,
                )
            print(f"{attack}: {told.total()} in {time.perf_counter() - begun:.0f} s")
            for text, count in told.most_common():
                print(f"  {count:5d}  {text}", flush=True)
            wrong += sum(count for text, count in told.items() if text.startswith("WRONG"))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
