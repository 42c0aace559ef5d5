"""The map of weak shapes as a picture. It needs matplotlib, the package's extra `plot`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from purcell_cli.lie_brackets.weak_shapes import ShapeStrength, weakest
from purcell_cli.pictures.style import save_figure, styled


def draw_map(found: Sequence[ShapeStrength], depth: int, path: Path) -> None:
    """Write the picture of the least singular values over bends and rolls; the same map is the same bytes."""
    bends = sorted({s.bend_rad for s in found})
    rolls = sorted({s.roll_rad for s in found})
    with styled():
        figure = Figure(figsize=(10.0, 4.2))
        for place, (title, ranks) in enumerate(
            (
                ("h1 + h2: the shape left free", [s.weak for s in found]),
                (f"brackets to depth {depth}: the limbs brought back", [s.strong for s in found]),
            )
        ):
            axes = figure.add_subplot(1, 2, 1 + place)
            axes.grid(False)
            least = np.array([weakest(rank)[0] for rank in ranks]).reshape(len(bends), len(rolls))
            shown = axes.imshow(np.log10(np.maximum(least, 1e-12)), origin="lower", aspect="auto", cmap="viridis")
            for (row, column), _ in np.ndenumerate(least):
                name = weakest(ranks[row * len(rolls) + column])[1]
                box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.6, "pad": 1.0}
                axes.annotate(name, (column, row), ha="center", va="center", fontsize=6, bbox=box)
            axes.set_xticks(range(len(rolls)), [f"{math.degrees(roll):.4g}" for roll in rolls])
            axes.set_yticks(range(len(bends)), [f"{math.degrees(bend):.4g}" for bend in bends])
            axes.set(title=title, xlabel="roll of limb 2's bend [deg]", ylabel="bend of both limbs [deg]")
            figure.colorbar(shown, ax=axes, label="log10 of the least singular value [L, rad]")
    save_figure(figure, path)
