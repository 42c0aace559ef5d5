"""A motion as a film: an animated GIF for slides and pages, or MP4."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import IO, Any

import numpy as np

from purcell_cli.errors import MissingPackageError, ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.pictures.surroundings import NOTHING, Surroundings

LONGEST_S = 10.0
"""A motion that takes longer is shown in this time, where no other is asked for [s]: a slide is looked at as long."""

MOST_FRAMES = 3000
"""Frames at most: two minutes at 25 a second, a minute's work."""

_FASTEST = {"gif": 50.0, "mp4": 120.0}
"""Frames in a second at most: browsers slow a GIF down that shows one for less than a fiftieth of a second."""

_SMALLEST, _LARGEST = 64, 3840
"""Pixels of a side, at least and at most."""

_REST_MS = 1000
"""How long a GIF shows the last frame before it begins again [ms]."""


@frozen_dataclass
class FilmOptions:
    """How a film is made.

    Attributes:
        ending: That of its file, "gif" or "mp4".
        fps: Frames in a second.
        duration_s: How long the film takes [s]; None for the motion's own time, and at most `LONGEST_S`.
        size: Width and height [pixels].

    Raises:
        ParameterError: A number that no film can have.
    """

    ending: str
    fps: float = 25.0
    duration_s: float | None = None
    size: tuple[int, int] = (640, 480)

    def __post_init__(self) -> None:
        if not 1.0 <= self.fps <= _FASTEST[self.ending]:
            most = f"{_FASTEST[self.ending]:g}"
            raise ParameterError(f"fps: a number from 1 to {most} is wanted for .{self.ending}, found {self.fps!r}")
        if self.duration_s is not None and not 0.0 < self.duration_s * self.fps <= MOST_FRAMES:
            wanted = f"a time above 0 of at most {MOST_FRAMES} frames, {MOST_FRAMES / self.fps:g} s,"
            raise ParameterError(f"duration: {wanted} is wanted, found {self.duration_s!r}")

    def times_s(self, table: Table) -> Array:
        """Return the motion's time at each frame, from its begin to its end [s]. Shape (n,)."""
        begin, end = float(table.time_s[0]), float(table.time_s[-1])
        lasts = min(end - begin, LONGEST_S) if self.duration_s is None else self.duration_s
        return np.linspace(begin, end, max(round(lasts * self.fps), 2))


def parsed_size(text: str) -> tuple[int, int]:
    """Return the width and the height of a text such as 640x480.

    Raises:
        ParameterError: The text says no size, or one that no film can have.
    """
    found = re.fullmatch(r"([0-9]{1,9})x([0-9]{1,9})", text.strip().lower())
    width, height = (int(found[1]), int(found[2])) if found else (0, 0)
    if not (_SMALLEST <= width <= _LARGEST and _SMALLEST <= height <= _LARGEST) or width % 2 or height % 2:
        wanted = f"WIDTHxHEIGHT such as 640x480, two even numbers from {_SMALLEST} to {_LARGEST},"
        raise ParameterError(f"size: {wanted} is wanted, found {text[:40]!r}")
    return width, height


def write_film(
    table: Table,
    swimmer: Swimmer,
    options: FilmOptions,
    stream: IO[bytes],
    progress: Callable[[int, int], None],
    around: Surroundings = NOTHING,
) -> int:
    """Write the film of a motion.

    Args:
        table: The motion.
        swimmer: The swimmer.
        options: How it is made.
        stream: Where to write; it can be sought in.
        progress: Takes how many frames are drawn, and of how many.
        around: What is around the motion.

    Returns:
        How many frames there are.

    Raises:
        MissingPackageError: pillow is not installed, or, for MP4, av.
    """
    try:
        from purcell_cli.pictures.film_frames import Palette, Stage
    except ImportError as error:
        if isinstance(error, MissingPackageError) or (error.name or "").partition(".")[0] != "PIL":
            raise
        raise _missing("pillow", "pillow>=10.1") from None
    times = options.times_s(table)
    stage = Stage(table, swimmer, times, options.size, around)

    def frames() -> Iterator[Any]:
        for k in range(len(times)):
            yield stage.frame(k)
            progress(k + 1, len(times))

    if options.ending == "gif":
        palette = Palette()
        indexed = (palette.indexed(frame) for frame in frames())
        ends = np.round(np.arange(1, len(times) + 1) * (100.0 / options.fps)).astype(int) * 10
        lasts = np.diff(ends, prepend=0).tolist()
        lasts[-1] += _REST_MS
        next(indexed).save(
            stream, format="GIF", save_all=True, append_images=indexed, duration=lasts, loop=0, optimize=False
        )
    else:
        _write_mp4(frames(), options, stream)
    return len(times)


def _write_mp4(frames: Iterator[Any], options: FilmOptions, stream: IO[bytes]) -> None:
    """Write frames as H.264 in MP4, which every player and slide program takes."""
    try:
        import av
    except ImportError:
        raise _missing("av", "av>=14.2") from None
    with av.open(stream, "w", format="mp4", options={"movflags": "+faststart", "fflags": "+bitexact"}) as container:
        video = container.add_stream("libx264", rate=Fraction(options.fps).limit_denominator(1000))
        video.width, video.height = options.size
        # What x264 weighs by later frames (mbtree) differs from time to time.
        video.pix_fmt, video.options = "yuv420p", {"crf": "20", "threads": "1", "x264-params": "mbtree=0"}
        for frame in frames:
            container.mux(video.encode(av.VideoFrame.from_image(frame)))
        container.mux(video.encode())


def _missing(name: str, wanted: str) -> MissingPackageError:
    return MissingPackageError(f"films need {name}, found none; install it: python -m pip install '{wanted}'")
