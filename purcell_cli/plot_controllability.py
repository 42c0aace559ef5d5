"""The map of weak shapes as a picture. It needs matplotlib, the package's extra `plot`."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from purcell_cli.errors import InputError, MissingPackageError
from purcell_cli.export import whole_file
from purcell_cli.weak_shapes import ShapeStrength, weakest

try:
    import matplotlib as mpl
    from matplotlib.figure import Figure
except ImportError:
    raise MissingPackageError(
        "pictures need matplotlib, found none; install it: python -m pip install 'matplotlib>=3.8'"
    ) from None

_FORMATS = ("png", "svg", "pdf")


def picture_format(path: Path) -> str:
    """Return the format that a picture's file ends in.

    Raises:
        InputError: The ending is none that can be drawn.
    """
    ending = path.suffix.removeprefix(".").lower()
    if ending not in _FORMATS:
        raise InputError(f"{path}: wanted a picture's ending ({', '.join(_FORMATS)}), found {path.suffix or 'none'}")
    return ending


def draw_map(found: Sequence[ShapeStrength], depth: int, path: Path) -> None:
    """Write the picture of the least singular values over bends and rolls; the same map is the same bytes."""
    bends = sorted({s.bend_rad for s in found})
    rolls = sorted({s.roll_rad for s in found})
    data = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "purcell", "font.size": 9, "figure.constrained_layout.use": True}):
        figure = Figure(figsize=(10.0, 4.2))
        for place, (title, ranks) in enumerate(
            (
                ("h1 + h2: the shape left free", [s.weak for s in found]),
                (f"brackets to depth {depth}: the limbs brought back", [s.strong for s in found]),
            )
        ):
            axes = figure.add_subplot(1, 2, 1 + place)
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
        form = picture_format(path)
        stamp = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form, {})
        figure.savefig(data, format=form, dpi=150, metadata=stamp)
    with whole_file(path) as stream:
        stream.write(data.getvalue())
