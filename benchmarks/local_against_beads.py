"""What links that feel each other's flow change: gaits, best amplitudes and convergence, by slenderness.

    python -m benchmarks.local_against_beads gaits --slenderness 0.05 0.035 0.025
    python -m benchmarks.local_against_beads amplitudes --slenderness 0.05 0.035 0.025
    python -m benchmarks.local_against_beads cruise --slenderness 0.02 --finer 1.5
    python -m benchmarks.local_against_beads loops --slenderness 0.02 --finer 2
    python -m benchmarks.local_against_beads pictures

The first four measure and keep their rows in `benchmarks/data/local_against_beads.json`; the last draws the pictures
of `docs/explanation/beads.md` from it and prints its tables. `gaits` and `amplitudes` make the table of the
beads first, in processor time that grows as the third power of one over the slenderness: 2 s at 0.01, four minutes at
0.002, where links are thinner than swimmers may have them. `cruise` and `loops` need none: they solve the beads along
planar strokes, and also more of them.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.polynomial import chebyshev
from scipy.integrate import solve_ivp

from purcell_cli import Swimmer, realise, stored_gaits
from purcell_cli.errors import GaitError
from purcell_cli.gaits.atlas import twist_in_lengths
from purcell_cli.gaits.gait import MOTIONS, Gait
from purcell_cli.gaits.joint_fit import refuse_far_stroke
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.kernel.beads import bead_resistance
from purcell_cli.mechanics import fluid as fluids
from purcell_cli.mechanics.beads import LOWER
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import work
from purcell_cli.pictures.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PINK
from purcell_cli.pictures.style import save_figure, styled

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "benchmarks" / "data" / "local_against_beads.json"
PICTURES = ROOT / "docs" / "pictures"
AMPLITUDES = np.linspace(0.1, 1.55, 30)
"""Half sides of the square loop that are tried [rad]: the table of the beads ends at 1.6."""
HALVES = (0.1, 0.5, 1.0, 1.1, 1.15, 1.2, 1.25, 1.3, 1.4)
"""Half sides of square loops whose beads are solved along the way [rad]."""
NODES = 11
"""Chebyshev nodes on a primitive of 2 rad: the twist is interpolated to 1e-8."""


TICKS = (0.002, 0.005, 0.01, 0.02, 0.05)
"""Slendernesses that a picture's axis names."""
LABEL_STEP = 0.014
"""How far labels of a picture stay apart, in its own unit: the height of their letters."""


def swimmer(slenderness: float, fluid: str) -> Swimmer:
    """Return the paper's swimmer of a slenderness."""
    return Swimmer(slenderness=slenderness, fluid=fluid)  # type: ignore[arg-type]


def cycle(gait: Gait, body: Swimmer, amplitude: float | None = None) -> dict[str, Any] | None:
    """Return the twist of a cycle [L, rad], its joint travel [rad] and its work over viscosity; None for no stroke."""
    try:
        stroke = realise(gait, body, amplitude)
        refuse_far_stroke(body, stroke)
    except GaitError:
        return None
    spent = np.sum(work(body, stroke.cycle, stroke.approach.shapes(COLLINEAR)[-1])) / body.viscosity_pa_s
    return {
        "twist": twist_in_lengths(body, stroke).tolist(),
        "travel_rad": stroke.cycle.joint_travel_rad,
        "work": float(spent),
        "amplitude_rad": stroke.amplitude_rad,
    }


def measure_gaits(slenderness: float) -> dict[str, Any]:
    """Return what each stored gait does in both models, its free angles solved anew in each."""
    out: dict[str, Any] = {}
    for name, gait in stored_gaits().items():
        pair = {fluid: cycle(gait, swimmer(slenderness, fluid)) for fluid in ("local", "beads")}
        out[name] = {"moves": gait.moves, **pair}
    return out


def measure_amplitudes(slenderness: float) -> dict[str, Any]:
    """Return what the square loop does over its half side, in both models."""
    gait = stored_gaits()["x-cruise"]
    return {
        fluid: [cycle(gait, swimmer(slenderness, fluid), float(a)) for a in AMPLITUDES] for fluid in ("local", "beads")
    }


def cruise(slenderness: float, finer: float, half_rad: float = 1.0) -> float:
    """Return how far a cycle of the square loop goes [L], its beads solved along the way.

    Args:
        slenderness: Radius over full length.
        finer: How many times as many beads as touch; more overlap.
        half_rad: Half the loop's side [rad].
    """
    count = round(finer / (2.0 * slenderness))
    along = (2.0 * np.arange(count) + 1.0) / count
    link, radius = np.repeat(np.arange(3), count), np.full(3 * count, 2.0 * slenderness)
    corners = half_rad * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])

    def twist(yaws: np.ndarray, rates: np.ndarray) -> np.ndarray:
        outwards = np.array([[1.0, 0.0, 0.0], about_axis(2, yaws[0])[:, 0], -about_axis(2, yaws[1])[:, 0]])
        arm = np.concatenate([(along - 1.0)[:, None] * outwards[0], *(along[:, None] * o for o in outwards[1:])])
        place = arm.copy()
        place[:, 0] += np.array([0.0, 1.0, -1.0])[link]
        full = np.zeros((12, 12))
        full[LOWER] = full[LOWER[::-1]] = bead_resistance(place, arm, radius, link)
        plane = [0, 1, 5]
        return -np.linalg.solve(full[np.ix_(plane, plane)], full[np.ix_(plane, [8, 11])] @ rates)

    here = np.zeros(3)
    parts = np.cos((np.arange(NODES) + 0.5) * (math.pi / NODES))
    for first, second in itertools.pairwise(corners):
        rates = 0.5 * (second - first)
        values = [twist(first + rates * (1.0 + part), rates) for part in parts]
        series = chebyshev.chebfit(parts, np.array(values), NODES - 1)

        def slope(time: float, pose: np.ndarray, series: np.ndarray = series) -> np.ndarray:
            vx, vy, turn = chebyshev.chebval(time, series)
            c, s = math.cos(pose[2]), math.sin(pose[2])
            return np.array([c * vx - s * vy, s * vx + c * vy, turn])

        here = solve_ivp(slope, (-1.0, 1.0), here, rtol=1e-10, atol=1e-12).y[:, -1]
    return float(np.hypot(here[0], here[1]))


def rounded(value: Any) -> Any:
    """Return values with numbers to nine digits."""
    if isinstance(value, float):
        return float(f"{value:.9g}")
    if isinstance(value, list):
        return [rounded(v) for v in value]
    return {k: rounded(v) for k, v in value.items()} if isinstance(value, dict) else value


def kept() -> dict[str, Any]:
    """Return the rows that are kept."""
    return (
        json.loads(DATA.read_text(encoding="utf-8")) if DATA.exists() else {"gaits": {}, "amplitudes": {}, "cruise": {}}
    )


def ratio(row: dict[str, Any]) -> tuple[float, float] | None:
    """Return what part of its motion among links alone a gait makes on beads, and the cosine between both."""
    if row["local"] is None or row["beads"] is None:
        return None
    alone, together = (np.array(row[fluid]["twist"]) for fluid in ("local", "beads"))
    if row["moves"] in MOTIONS:
        k = MOTIONS.index(row["moves"])
        return float(together[k] / alone[k]), float(np.sign(together[k] * alone[k]))
    sizes = np.linalg.norm(alone), np.linalg.norm(together)
    return float(sizes[1] / sizes[0]), float(alone @ together / (sizes[0] * sizes[1]))


def best(rows: list[dict[str, Any] | None], spent: str, power: float) -> tuple[float, float]:
    """Return the amplitude that goes furthest for what it spends, and by how many times that of 0.5 rad does less."""
    there = [row for row in rows if row is not None]
    amplitudes = np.array([row["amplitude_rad"] for row in there])
    worth = np.array([abs(row["twist"][0]) ** power / row[spent] for row in there])
    k = int(np.argmax(worth))
    at = float(amplitudes[k])
    if 0 < k < len(worth) - 1:  # the parabola through three neighbours
        a, b, c = worth[k - 1 : k + 2]
        at += 0.5 * float((a - c) / (a - 2.0 * b + c)) * float(amplitudes[k + 1] - amplitudes[k])
    return at, float(worth[k] / np.interp(0.5, amplitudes, worth))


def draw(rows: dict[str, Any]) -> None:
    """Draw the pictures and print the tables."""
    draw_gaits(rows["gaits"])
    draw_amplitudes(rows["amplitudes"])
    draw_cruise(rows["cruise"])
    print("\n| slenderness, beads | best half side | over 0.5 rad | of links alone at 0.1 rad | at 1 rad |")
    gait, alone = stored_gaits()["x-cruise"], swimmer(0.01, "local")
    plain = [abs(row["twist"][0]) if (row := cycle(gait, alone, half)) else math.nan for half in HALVES]
    for key, ways in {**rows["loops"], "alone": plain}.items():
        speed = np.array(ways) / np.array(HALVES)
        near = np.polyfit(HALVES[3:], speed[3:], 3)
        fine = np.linspace(HALVES[3], HALVES[-1], 301)
        at = float(fine[np.argmax(np.polyval(near, fine))])
        most = float(np.max(np.polyval(near, fine))) / speed[1]
        print(f"| {key} | {at:.3f} | {most:.3f} | {ways[0] / plain[0]:.3f} | {ways[2] / plain[2]:.3f} |")


def draw_gaits(rows: dict[str, Any]) -> None:
    """Draw and print what is left of each gait, by slenderness."""
    sizes = sorted(rows, key=float)
    names = [name for name, gait in stored_gaits().items() if name in rows[sizes[0]] and not name.startswith("printed")]
    print("\n| gait | moves |" + "".join(f" {s} |" for s in sizes) + "\n" + "| --- " * (2 + len(sizes)) + "|")
    with styled():
        figure = Figure(figsize=(7.2, 4.2))
        axes, ends = figure.add_subplot(), []
        for name in stored_gaits():
            found = {s: ratio(rows[s][name]) for s in sizes if name in rows[s]}
            cells = [f" {v[0]:.2f} |" if (v := found.get(s)) else " - |" for s in sizes]
            turned = min((v[1] for v in found.values() if v), default=1.0)
            note = "" if turned > 0.9 else f" (cosine {turned:.2f})"
            print(f"| `{name}`{note} | {rows[sizes[0]][name]['moves']} |" + "".join(cells))
            there = {float(s): v[0] for s, v in found.items() if v}
            if name in names and there:
                colour = {"x": BLUE, "y": GREEN, "z": GREEN, "none": GREY}.get(rows[sizes[0]][name]["moves"], ORANGE)
                axes.plot(list(there), list(there.values()), "o-", color=colour, markersize=3, linewidth=1.0)
                ends.append((there[max(there)], name))
        axes.axhline(1.0, color=BLACK, linewidth=0.8)
        height = 0.0
        for end, name in sorted(ends):
            height = max(height + LABEL_STEP, end)
            axes.annotate(name, (float(sizes[-1]), height), (6, -2), textcoords="offset points", fontsize=6)
        axes.set_xscale("log")
        axes.set_xlim(0.8 * float(sizes[0]), 1.9 * float(sizes[-1]))
        axes.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
        axes.minorticks_off()
        axes.set(xlabel="slenderness", ylabel="motion of a cycle, of that among links alone")
    save_figure(figure, PICTURES / "beads-gaits.svg")


def draw_amplitudes(rows: dict[str, Any]) -> None:
    """Draw and print which square loop is best, by slenderness."""
    print(
        "\n| slenderness | per travel | over 0.5 rad | alone | per work | over 0.5 rad | alone |\n" + "| --- " * 7 + "|"
    )
    with styled():
        figure = Figure(figsize=(7.2, 3.4))
        axes = figure.add_subplot()
        for k, s in enumerate(sorted(rows, key=float)):
            cells = []
            for spent, power in (("travel_rad", 1.0), ("work", 2.0)):
                at = {fluid: best(rows[s][fluid], spent, power) for fluid in ("beads", "local")}
                cells += [f"{at['beads'][0]:.3f}", f"{at['beads'][1]:.2f}", f"{at['local'][0]:.3f}"]
            print(f"| {s} | " + " | ".join(cells) + " |")
            for fluid, style in (("beads", "-"), ("local", ":")):
                there = [row for row in rows[s][fluid] if row is not None]
                worth = [abs(row["twist"][0]) / row["travel_rad"] for row in there]
                label = f"{s}" if fluid == "beads" else ("links alone, any" if k == 0 else None)
                colour = BLACK if fluid == "local" else (BLUE, GREEN, ORANGE, PINK, GREY, BLACK)[k % 6]
                if fluid == "beads" or k == 0:
                    axes.plot([row["amplitude_rad"] for row in there], worth, style, color=colour, label=label)
        axes.set(xlabel="half side of the loop [rad]", ylabel="distance per joint travel [L/rad]")
        axes.legend(title="slenderness")
    save_figure(figure, PICTURES / "beads-amplitudes.svg")


def draw_cruise(rows: dict[str, float]) -> None:
    """Draw and print the cycle of x-cruise at 1 rad, by slenderness and number of beads."""
    found: dict[float, dict[float, float]] = {}
    for key, value in rows.items():
        s, finer = map(float, key.split())
        found.setdefault(finer, {})[s] = value
    alone = cycle(stored_gaits()["x-cruise"], swimmer(0.01, "local"))
    limit = abs(alone["twist"][0]) if alone else math.nan
    print(f"\nlinks alone: {limit:.4f} L")
    print("\n| slenderness |" + "".join(f" {f:g} |" for f in sorted(found)) + "\n" + "| --- " * (1 + len(found)) + "|")
    for s in sorted(found[1.0]):
        print(f"| {s:g} |" + "".join(f" {found[f][s]:.4f} |" if s in found[f] else " |" for f in sorted(found)))
    with styled():
        figure = Figure(figsize=(7.2, 3.4))
        axes = figure.add_subplot()
        for finer, colour in zip(sorted(found), (GREY, BLUE, PINK, GREEN, ORANGE), strict=False):
            x = np.array(sorted(found[finer]))
            label = "touching" if finer == 1.0 else f"{finer:g} times as many"
            y = [found[finer][s] for s in x]
            axes.plot(1.0 / np.log(1.0 / x), y, "o-", color=colour, markersize=3, label=label)
        axes.plot([0.0], [limit], "s", color=BLACK, label="links alone")
        axes.set(xlabel="1 / ln(1 / slenderness)", ylabel="cycle of x-cruise [L]")
        axes.legend(title="beads")
    save_figure(figure, PICTURES / "beads-cruise.svg")


def main() -> None:
    """Measure, or draw what was measured."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("gaits", "amplitudes", "cruise", "loops", "pictures"))
    parser.add_argument("--slenderness", type=float, nargs="+", default=[0.05])
    parser.add_argument("--finer", type=float, default=1.0)
    asked = parser.parse_args()
    rows = kept()
    if asked.what == "pictures":
        return draw(rows)
    thin = min(*asked.slenderness, fluids.BEADS["slenderness"][0])
    fluids.BEADS = {**fluids.BEADS, "slenderness": (thin, 0.2)}  # tables may take minutes here
    for s in asked.slenderness:
        if asked.what == "cruise":
            rows["cruise"][f"{s:g} {asked.finer:g}"] = cruise(s, asked.finer)
        elif asked.what == "loops":
            found = [cruise(s, asked.finer, half) for half in HALVES]
            rows.setdefault("loops", {})[f"{s:g} {asked.finer:g}"] = found
        else:
            rows[asked.what][f"{s:g}"] = (measure_gaits if asked.what == "gaits" else measure_amplitudes)(s)
        DATA.parent.mkdir(exist_ok=True)
        DATA.write_text(json.dumps(rounded(rows), separators=(",", ":")) + "\n", encoding="utf-8")
    return None


if __name__ == "__main__":
    main()
