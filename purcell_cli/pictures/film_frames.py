"""The frames of a film of a motion: the links from the side and from above, the base's way, the time and the stroke.

Each frame is drawn at twice its size and halved, which smooths edges. The view is that of the page of `html_view`.
Conventions: `rotations`.
"""

from __future__ import annotations

import math

import numpy as np
from PIL import Image, ImageColor, ImageDraw, ImageFont

from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.table_sampling import base_at, limbs_at, rows_at
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.pictures.colours import AMBER, BLACK, BLUE, GREY, ORANGE
from purcell_cli.pictures.surroundings import NOTHING, Surroundings
from purcell_cli.wording import length_unit

_AZIMUTH, _ELEVATION = -1.0, 0.42
"""Where the motion is seen from [rad]."""

_FILLED = 0.86
"""Which part of a frame the motion fills."""

_TWICE = 2
"""How many times its size a frame is drawn at."""

_THINNEST = 2.5
"""Width of a link at least [pixels]."""

_WAY, _TRACE, _GHOST = "#cccccc", "#888888", "#dddddd"
"""Colours of the whole way of the base, of what is done of it, and of the swimmer at its start."""

_LINKS = (BLACK, BLUE, ORANGE)
"""Colours of base, limb 1 and limb 2."""

_DOT = 8
"""Radius of a waypoint on a frame of twice the size [pixels]."""

_MARK = 0.35
"""How far marks that show rolls stand out of the links, in units of L."""

_AROUND = 0.25
"""How far beyond the motion surroundings are shown, as a part of the motion's extent on the frame."""

_SHADES = (0.75, 1.0)
"""How bright triangles are that are seen along their surface, and straight on."""

_SURFACES = {"obstacle": (96, 125, 139), "tolerance": (230, 159, 0)}
"""Colours of surfaces: red, green and blue."""

_MOST_POINTS = 2000
"""Points of the base's way that are drawn, at most."""


class Stage:
    """A motion and the frame that it is seen in.

    Args:
        table: The motion.
        swimmer: The swimmer.
        times_s: When frames are drawn [s]. Shape (n,).
        size: Width and height of a frame [pixels].
        around: What is around the motion.
    """

    def __init__(
        self, table: Table, swimmer: Swimmer, times_s: Array, size: tuple[int, int], around: Surroundings = NOTHING
    ) -> None:
        self._table, self._swimmer, self._times, self._size = table, swimmer, times_s, size
        base = base_at(table, times_s)
        base[:, :3, 3] -= table.origin_m
        self._ends, self._marks = _links(swimmer, base, [limbs_at(table, limb, times_s) for limb in (1, 2)])
        way = np.unique(np.linspace(0, len(table.time_s) - 1, _MOST_POINTS).astype(np.int64))
        self._way_s, self._way = table.time_s[way], table.position_m[way] - table.origin_m
        right = np.array([-math.sin(_AZIMUTH), math.cos(_AZIMUTH), 0.0])
        up = np.array(
            [
                -math.sin(_ELEVATION) * math.cos(_AZIMUTH),
                -math.sin(_ELEVATION) * math.sin(_AZIMUTH),
                math.cos(_ELEVATION),
            ]
        )
        self._screen, self._towards = np.stack([right, -up]), np.cross(right, up)
        middles, radius = self._ends[:, 0].mean(axis=1), swimmer.body_radius_m
        body = [middles + side * radius * axis for axis in self._screen for side in (-1.0, 1.0)] if radius else []
        drawn = [self._ends.reshape(-1, 3), self._marks.reshape(-1, 3), self._way, *body]
        seen = np.concatenate(drawn) @ self._screen.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        skins = [(one, one.triangles - table.origin_m) for one in around.skins(table)]
        marks = [one.place_m - table.origin_m for one in around.marks(table)]
        curve = around.curve_m - table.origin_m
        other = np.concatenate([*(part.reshape(-1, 3) for _, part in skins), curve, *(m[None] for m in marks)])
        if len(other):
            more = _AROUND * np.max(high - low)
            there = np.clip(other @ self._screen.T, low - more, high + more)
            low, high = np.minimum(low, there.min(axis=0)), np.maximum(high, there.max(axis=0))
        self._scale = _TWICE * _FILLED * float(np.min(np.array(size) / np.maximum(high - low, 1e-300)))
        self._centre = 0.5 * (low + high)
        self._background = Image.new("RGB", (_TWICE * size[0], _TWICE * size[1]), "white")
        pen = ImageDraw.Draw(self._background, "RGBA")
        for one, triangles in skins:
            self._skin(pen, triangles, _SURFACES[one.of], one.alpha)
        self._line(pen, curve, AMBER, 1.2)
        for x, y in self._seen(np.array(marks).reshape(-1, 3)):
            pen.ellipse((x - _DOT, y - _DOT, x + _DOT, y + _DOT), fill=AMBER)
        self._font = ImageFont.load_default(size=_TWICE * max(size[1] / 34.0, 10.0))

    def frame(self, k: int) -> Image.Image:
        """Return a frame by its number: an image of red, green and blue."""
        width, height = (_TWICE * n for n in self._size)
        image = self._background.copy()
        pen = ImageDraw.Draw(image)
        self._line(pen, self._way, _WAY, 1.2)
        self._line(pen, self._way[self._way_s <= self._times[k]], _TRACE, 1.6)
        self._swim(pen, 0, (_GHOST,) * 3)
        self._swim(pen, k, _LINKS)
        self._words(pen, k, width, height)
        return image.reduce(_TWICE)

    def _seen(self, points: Array) -> list[tuple[float, float]]:
        """Return where points are on the frame [pixels]."""
        flat = (points @ self._screen.T - self._centre) * self._scale + 0.5 * _TWICE * np.array(self._size)
        return [(float(x), float(y)) for x, y in np.round(flat, 3)]

    def _skin(self, pen: ImageDraw.ImageDraw, triangles: Array, colour: tuple[int, int, int], alpha: float) -> None:
        """Draw a translucent surface, the farthest triangle first, brighter where it is seen straight on."""
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        facing = np.abs(normal @ self._towards) / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
        light = np.interp(facing, (0.0, 1.0), _SHADES)
        for k in np.argsort(triangles.mean(axis=1) @ self._towards, kind="stable").tolist():
            red, green, blue = (round(part * light[k]) for part in colour)
            pen.polygon(self._seen(triangles[k]), fill=(red, green, blue, round(255 * alpha)))

    def _line(self, pen: ImageDraw.ImageDraw, points: Array, colour: str, width: float) -> None:
        if len(points) > 1:
            pen.line(self._seen(points), fill=colour, width=round(_TWICE * width), joint="curve")

    def _swim(self, pen: ImageDraw.ImageDraw, k: int, colours: tuple[str, ...]) -> None:
        """Draw the swimmer, the farthest link first."""
        radii = self._swimmer.radii_m
        depth = self._ends[k].mean(axis=1) @ self._towards
        for link in np.argsort(depth, kind="stable").tolist():
            self._line(pen, self._marks[k, link], colours[link], 1.2)
            radius = max(radii[link] * self._scale, 0.5 * _TWICE * _THINNEST)
            ends = self._seen(self._ends[k, link])
            pen.line(ends, fill=colours[link], width=round(2.0 * radius))
            discs = [(*end, radius) for end in ends]
            if link == 0 and self._swimmer.body_radius_m:
                middle = self._seen(self._ends[k, link].mean(axis=0, keepdims=True))[0]
                discs.append((*middle, self._swimmer.body_radius_m * self._scale))
            for x, y, disc in discs:
                pen.ellipse((x - disc, y - disc, x + disc, y + disc), fill=colours[link])

    def _words(self, pen: ImageDraw.ImageDraw, k: int, width: int, height: int) -> None:
        """Write the time, the phase and the stroke, and draw a bar of a known length."""
        row = int(rows_at(self._table, self._times[k : k + 1])[0])
        time, last = float(self._times[k]), float(self._table.time_s[-1])
        margin, line = 0.02 * height, 0.045 * height
        digits = 2 if last < 10.0 else 1 if last < 1000.0 else 0
        pen.text((margin, margin), f"{time:.{digits}f} of {last:.{digits}f} s", fill=GREY, font=self._font)
        stroke = f"phase {int(self._table.phase[row])}: {self._table.gait[row]}"
        text = "".join(c if c.isascii() and c.isprintable() else "?" for c in stroke)[:60]
        pen.text((margin, margin + line), text, fill=GREY, font=self._font)
        wanted = 0.2 * width / self._scale
        power = 10.0 ** math.floor(math.log10(wanted))
        length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= wanted * 1.0001)
        factor, unit = length_unit(length)
        y = height - 2.0 * margin
        pen.line([(margin, y), (margin + length * self._scale, y)], fill=GREY, width=2 * _TWICE)
        label = f"{length * factor:g} {unit}".replace("\N{MICRO SIGN}", "u")
        pen.text((margin, y - line - margin), label, fill=GREY, font=self._font)


class Palette:
    """All that is drawn as 256 colours, the same for every frame: each on its way to white and to the others."""

    def __init__(self) -> None:
        names = (BLACK, BLUE, ORANGE, GREY, _WAY, _TRACE, _GHOST)
        colours = [np.array(ImageColor.getrgb(name), dtype=np.float64) for name in names]
        around = [np.array(colour, dtype=np.float64) for colour in _SURFACES.values()]
        entries = [np.full(3, 255.0)]
        entries += [255.0 + share * (c - 255.0) for c in colours for share in np.linspace(0.0625, 1.0, 16)]
        pairs = [(a, b) for k, a in enumerate(colours) for b in colours[:k]]
        entries += [a + share * (b - a) for a, b in pairs for share in np.linspace(0.2, 0.8, 4)]
        tints = [255.0 + share * (c - 255.0) for c in around for share in np.linspace(0.0625, 1.0, 16)]
        self._entries = np.round(np.array([*entries[: 256 - len(tints)], *tints])).astype(np.int64)
        key = np.arange(1 << 16)
        red, green, blue = key >> 11, (key >> 5) & 63, key & 31  # the colour of so many bits each
        shown = np.stack([red * 255 // 31, green * 255 // 63, blue * 255 // 31], axis=1)
        cross = shown @ self._entries.T
        self._nearest = np.argmin(np.sum(self._entries**2, axis=1) - 2 * cross, axis=1).astype(np.uint8)

    def indexed(self, image: Image.Image) -> Image.Image:
        """Return an image of red, green and blue by the palette's nearest colours."""
        pixels = np.asarray(image).astype(np.int64)
        key = (pixels[..., 0] >> 3 << 11) | (pixels[..., 1] >> 2 << 5) | pixels[..., 2] >> 3
        out = Image.fromarray(self._nearest[key])
        out.putpalette(self._entries.ravel().tolist())
        return out


def _links(swimmer: Swimmer, base: Array, limbs: list[Array]) -> tuple[Array, Array]:
    """Return the ends of base, limb 1 and limb 2, and their marks of roll, in the world. Each of shape (n, 3, 2, 3)."""
    b, one, two = swimmer.halves_m
    ends, marks = np.empty((len(base), 3, 2, 3)), np.empty((len(base), 3, 2, 3))
    own = [np.broadcast_to(np.eye(3), limbs[0].shape), *limbs]
    begins, lengths = ((-b, 0.0, 0.0), (b, 0.0, 0.0), (-b, 0.0, 0.0)), (2.0 * b, 2.0 * one, -2.0 * two)
    for k, (turn, begin, length) in enumerate(zip(own, begins, lengths, strict=True)):
        ends[:, k, 0] = begin
        ends[:, k, 1] = np.array(begin) + length * turn[:, :, 0]
        middle = 0.5 * (ends[:, k, 0] + ends[:, k, 1])
        marks[:, k, 0], marks[:, k, 1] = middle, middle + _MARK * swimmer.length_m * turn[:, :, 2]
    return tuple(  # type: ignore[return-value]  # two of them
        matmul(part.reshape(len(base), 6, 3), np.swapaxes(base[:, :3, :3], 1, 2)).reshape(part.shape)
        + base[:, None, None, :3, 3]
        for part in (ends, marks)
    )
