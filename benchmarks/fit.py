"""What fitted drag is worth: ``python benchmarks/fit.py [predict|errors|learn]...``.

predict: from 200 s of motion of links that feel each other, the fitted model predicts where other plans end. By how
many times less it is off than the paper's swimmer, over random plans; without noise, and measured with 1e-3 L and
0.1 degree.
errors: how often true factors are within two standard errors, over seeds.
learn: how often `purcell track` plans again on stored scenarios, with and without a model that is fitted on the way.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

from purcell_cli import Configuration, MeasuredTrajectory, Swimmer, fit, load_scenario, plan, stored_scenarios
from purcell_cli.feedback.drag_factors import What, factors_of, with_factors
from purcell_cli.feedback.learn import Learning
from purcell_cli.feedback.simulate import simulate
from purcell_cli.feedback.track import track
from purcell_cli.geometry import se3
from purcell_cli.motion.trajectory import Trajectory, as_table

BEADS = Swimmer(fluid="beads")
PLANS = 30
TRAINED_S = 200.0
SEEDS = 60


def random_goal(rng: np.random.Generator) -> tuple[Configuration, Configuration]:
    """Return a start and a goal: up to 3 L away, turned by up to 60 degrees, limbs bent by up to 40 degrees."""
    away = rng.normal(size=3)
    away *= rng.uniform(0.02, 0.3) / np.linalg.norm(away)
    bends = rng.uniform(-40.0, 40.0, (4, 3)) * [1.0, 1.0, 0.5]
    start = Configuration.from_angles((0, 0, 0), (0, 0, 0), tuple(bends[0]), tuple(bends[1]))
    turn = rng.uniform(-60.0, 60.0, 3)
    return start, Configuration.from_angles(tuple(away), tuple(turn), tuple(bends[2]), tuple(bends[3]))


def measured(trajectory: Trajectory, seconds: float = np.inf, noise: float = 0.0, seed: int = 0) -> MeasuredTrajectory:
    """Return the beginning of a trajectory, measured with noise of so many 1e-3 L and 0.1 degree."""
    rows = slice(0, int(np.searchsorted(trajectory.time_s, seconds, side="right")))
    rng = np.random.default_rng(seed)
    twist = rng.normal(size=(len(trajectory), 6)) * np.repeat([1e-4, np.radians(0.1)], 3) * noise
    pose = se3.normalised(trajectory.pose @ se3.exp(twist))[rows]
    return MeasuredTrajectory(trajectory.time_s[rows], pose, trajectory.shape[rows], np.ones(len(pose), dtype=bool))


def off(found: Configuration, wanted: Configuration) -> float:
    """Return how far one end is from another, L and rad together."""
    twist = se3.log(se3.inverse(found.pose) @ wanted.pose)
    return float(np.linalg.norm(twist / np.repeat([0.1, 1.0], 3)))


def predict() -> None:
    """Print by how many times less the fitted models are off."""
    rng = np.random.default_rng(7)
    tables = []
    while len(tables) < PLANS:
        solution = plan(*random_goal(rng))
        tables.append(as_table(solution.trajectory))
    truths = [simulate(table, BEADS).end for table in tables]
    nominal = [off(simulate(table, Swimmer()).end, truth) for table, truth in zip(tables, truths, strict=True)]
    print(f"the paper's swimmer is off by {np.median(nominal):.3g} in the median (L and rad together)")
    for name in ("half-turn", "far"):
        scenario = load_scenario(stored_scenarios()[name])
        real = simulate(as_table(plan(scenario.start, scenario.goal).trajectory), BEADS).trajectory
        for noise in (0.0, 1.0):
            for what in What:
                begun = time.process_time()
                found = fit(measured(real, TRAINED_S, noise), Swimmer(), what)
                lasted = time.process_time() - begun
                fitted = [off(simulate(t, found.swimmer).end, truth) for t, truth in zip(tables, truths, strict=True)]
                gains = np.array(nominal) / np.array(fitted)
                low, middle, high = np.quantile(gains, [0.1, 0.5, 0.9])
                print(
                    f"{name:10s} noise {noise:g} {what:6s}: {middle:5.1f} times better in the median ({low:.1f} to "
                    f"{high:.1f}), worse in {np.sum(gains < 1.0)} of {len(gains)}; fitted in {lasted:.1f} s"
                )


def errors() -> None:
    """Print how often true factors are within two standard errors."""
    factors, rng = factors_of(What.KINDS), np.random.default_rng(3)
    inside, scores = 0, []
    goal = Configuration.from_angles((0.02, 0.01, 0.005), (10, 5, 20), (20, 0, 0), (0, 10, 0))
    table = as_table(plan(Configuration(), goal).trajectory)
    for seed in range(SEEDS):
        logs = rng.normal(size=len(factors)) * 0.15
        real = simulate(table, with_factors(Swimmer(), factors, logs.tolist())).trajectory
        found = fit(measured(real, noise=1.0, seed=seed), Swimmer())
        for one, log in zip(found.factors, logs, strict=True):
            if one.standard_error is not None:
                scores.append((one.value - np.exp(log)) / one.standard_error)
    inside = int(np.sum(np.abs(scores) < 2.0))
    print(f"{inside} of {len(scores)} factors within two standard errors ({inside / len(scores):.1%}); "
          f"root mean square {np.sqrt(np.mean(np.square(scores))):.2f}")  # fmt: skip


def learn() -> None:
    """Print how often it is planned again."""
    counts: dict[bool, list[int]] = {False: [], True: []}
    for name, path in stored_scenarios().items():
        scenario = load_scenario(path)
        if scenario.swimmer != Swimmer():
            continue
        line = f"{name:18s}"
        for learns in counts:
            begun = time.process_time()
            better = Learning(Swimmer()) if learns else lambda _: None
            found = track(scenario.start, scenario.goal, BEADS, fitted=better)
            counts[learns].append(found.replans if found.arrived else 99)
            line += f" {'learning' if learns else 'plain':8s} {found.replans} replans"
            line += f" {'' if found.arrived else 'NOT ARRIVED '}{found.joint_travel_rad:.4g} rad"
            line += f" {time.process_time() - begun:.0f} s;"
        print(line, flush=True)
    for learns, many in counts.items():
        print(f"learn {learns}: {np.median(many):g} replans in the median, {max(many)} at most")


PARTS: dict[str, Callable[[], None]] = {"predict": predict, "errors": errors, "learn": learn}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[[], *PARTS], metavar="PART", help="all where none is named")
    for chosen in parser.parse_args().parts or PARTS:
        PARTS[chosen]()
