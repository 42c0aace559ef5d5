"""What the flow costs among links that feel each other's flow: ``python -m benchmarks.flow``.

Of 27 primitives, in pairs: links alone, then links that feel each other, processor time. Walks turn limbs at random
within 1 rad, wide ones within 1.5; squares are of both limbs' yaw and pitch, as strokes are.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable

import numpy as np

from purcell_cli import Swimmer
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.kernel.shapes import shapes_along
from purcell_cli.mechanics.collocation import Accuracy, flow_of
from purcell_cli.mechanics.lift import EXACT, SEARCHING

PRIMITIVES = 27
MOST_RAD, WIDE_RAD = 1.0, 1.5
ROUNDS, SECONDS = 5, 0.1
"""How often each is timed, and how long at least; the least time of a round counts."""
COLLINEAR = np.stack([np.eye(3), np.eye(3)])

Primitives = tuple[Array, Array, Array]
"""Controls, angles and shapes."""


def walk(seed: int, most_rad: float = MOST_RAD) -> Primitives:
    """Return primitives at random angles that keep limbs bent by at most so much."""
    rng = np.random.default_rng(seed)
    limbs, controls, angles = [np.eye(3), np.eye(3)], list[int](), list[float]()
    while len(controls) < PRIMITIVES:
        control, angle = int(rng.integers(6)), float(rng.uniform(-1.0, 1.0))
        turned = limbs[control // 3] @ about_axis(control % 3, angle)
        if turned[0, 0] > np.cos(most_rad):
            limbs[control // 3] = turned
            controls.append(control)
            angles.append(angle)
    return with_shapes(controls, angles)


def squares() -> Primitives:
    """Return square strokes in yaw, then in pitch."""
    controls = [(2, 5, 2, 5)[k % 4] if k < 12 else (1, 4, 1, 4)[k % 4] for k in range(PRIMITIVES)]
    return with_shapes(controls, [MOST_RAD * (1.0, 1.0, -1.0, -1.0)[k % 4] for k in range(PRIMITIVES)])


def with_shapes(controls: list[int], angles: list[float]) -> Primitives:
    """Return primitives with the shapes before, between and after them."""
    control, angle = np.array(controls), np.array(angles)
    return control, angle, shapes_along(COLLINEAR, control, angle)


def seconds_of(call: Callable[[], object]) -> float:
    """Return the processor time of a call [s]."""
    count, begun = 0, time.process_time()
    while time.process_time() - begun < SECONDS:
        call()
        count += 1
    return (time.process_time() - begun) / count


def timed(body: Swimmer, accuracy: Accuracy, motion: Primitives) -> tuple[float, float]:
    """Return the times of the flow and of the flow with its derivatives [s]."""
    control, angle, shapes = motion
    flow, rates = flow_of(body, accuracy), np.zeros((PRIMITIVES, 6))
    rates[np.arange(PRIMITIVES), control] = np.sign(angle)
    return (
        seconds_of(lambda: flow.pieces(shapes[:-1], rates, np.abs(angle))),
        seconds_of(lambda: flow.with_derivatives(shapes, control, angle)),
    )


def main() -> None:
    """Measure and print."""
    bodies = Swimmer(), dataclasses.replace(Swimmer(), fluid="beads")
    motions = {
        "walks": [walk(seed) for seed in range(4)],
        "wide walks": [walk(seed, WIDE_RAD) for seed in range(4)],
        "squares": [squares()],
    }
    for name, many in motions.items():
        for told, accuracy in (("exact", EXACT), ("searching", SEARCHING)):
            rounds = [[[timed(body, accuracy, one) for one in many] for body in bodies] for _ in range(ROUNDS)]
            alone, together = np.min(rounds, axis=0).mean(axis=1) * 1e3
            for what, one, other in zip(("flow", "with derivatives"), alone, together, strict=True):
                line = f"alone {one:.3f} ms, together {other:.3f} ms, {other / one:.1f} times"
                print(f"{name}, {told}, {what}: {line}", flush=True)


if __name__ == "__main__":
    main()
