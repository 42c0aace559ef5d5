"""What all pictures share: style, formats and how they are saved."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np

from purcell_cli.errors import InputError, MissingPackageError
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.geometry.rotations import Array
from purcell_cli.pictures.colours import GREY
from purcell_cli.pictures.settings import untouched_by_the_user

try:
    with untouched_by_the_user():
        import matplotlib as mpl
    from matplotlib.figure import Figure
except ImportError:
    raise MissingPackageError(
        "pictures need matplotlib, found none; install it: python -m pip install 'matplotlib>=3.10.7'"
    ) from None

FORMATS = ("png", "svg", "pdf")
"""The formats of a picture, by the file's ending."""

_STYLE: Any = {
    "axes.edgecolor": GREY,
    "axes.grid": True,
    "axes.labelsize": 9,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "figure.constrained_layout.use": True,
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.4,
    "path.simplify_threshold": 0.5,
    "savefig.dpi": 150,
    "svg.hashsalt": "purcell",
}
"""Settings of matplotlib for every picture: sizes in points; the salt gives a picture the same bytes each time."""


_OF_THE_SCREEN = {"backend", "backend_fallback", "interactive", "toolbar", "timezone", "webagg.open_in_browser"}
"""Settings that do not change a picture's file, and that some versions let nobody set twice."""

_BACKENDS = {"png": "agg", "svg": "svg", "pdf": "pdf"}
"""What writes each format, whatever the user's screen needs."""


def picture_format(path: Path) -> str:
    """Return the format that a picture's file ends in.

    Raises:
        InputError: The ending is none of `FORMATS`.
    """
    ending = path.suffix.removeprefix(".").lower()
    if ending not in FORMATS:
        raise InputError(f"{path}: wanted a picture's ending ({', '.join(FORMATS)}), found {path.suffix or 'none'}")
    return ending


def styled() -> AbstractContextManager[None]:
    """Return the context in which figures are drawn and written: matplotlib's own settings and the pictures' style."""
    own = {name: value for name, value in dict.items(mpl.rcParamsDefault) if name not in _OF_THE_SCREEN}
    return mpl.rc_context(own | _STYLE)


def save_figure(figure: Figure, path: Path, dpi: float | None = None) -> None:
    """Write a picture in the format of its file's ending, without a date.

    Args:
        figure: The picture.
        path: Its file.
        dpi: Dots per inch of what is drawn as pixels; None for those of the style.

    Raises:
        InputError: The ending is none of `FORMATS`, or the file cannot be written.
    """
    form = picture_format(path)
    undated: dict[str, dict[str, None]] = {
        "png": {"Software": None},
        "svg": {"Date": None, "Creator": None},
        "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    }
    with styled(), whole_file(path) as stream:
        figure.savefig(stream, format=form, dpi=dpi, backend=_BACKENDS[form], metadata=undated[form])


def make_folder(path: Path) -> None:
    """Make a folder for pictures where there is none.

    Raises:
        InputError: It cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{path}: wanted a folder to write to, found none that can be made ({error.strerror})"
        ) from None


def control_legs(rate: Array) -> list[tuple[int, int]]:
    """Return the first row of each stretch of the same controls, (n, 6), and the row that ends it."""
    switch = np.flatnonzero(np.any(rate[1:] != rate[:-1], axis=1)) + 1
    return list(zip([0, *switch[:-1]], switch, strict=True)) if len(switch) else []
