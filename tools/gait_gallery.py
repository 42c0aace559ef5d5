"""Write ``docs/explanation/gaits.md`` and its pictures anew: ``python tools/gait_gallery.py``.

Every number on the page is computed here; a test compares the page with what this would write.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from purcell_cli import Configuration, Swimmer, realise, stored_gaits
from purcell_cli.cli.pictures import PAPER_MOTIONS, PRINTED
from purcell_cli.gaits.gait import Gait, Stroke
from purcell_cli.geometry.rotations import as_euler

DOCS = Path(__file__).resolve().parent.parent / "docs"
PAGE = DOCS / "explanation" / "gaits.md"
PICTURES = DOCS / "pictures"
SHOWN = (*PAPER_MOTIONS, *sorted(set(stored_gaits()) - {*PAPER_MOTIONS, *PRINTED}))
CONTRASTS = ("printed-y", "printed-psi")

_SMOOTH_S = 0.02
_HEAD = """\
# Gaits in pictures

What the stored gaits look like, for the paper's swimmer at their default amplitudes. This page and its pictures are
written by `python tools/gait_gallery.py`. `purcell plot NAME` draws any gait at any amplitude and for any swimmer,
your own gaits too; `purcell figures` draws the paper's six motions and its printed sequences, each as a stroke, as
poses and against time; `purcell gait NAME --out swim.csv` and then `purcell view swim.csv` let you watch one.

**How to read them.** A gait whose limbs stay in one plane is a closed line in the plane of its two joint angles. The
white dot is the collinear shape, where it begins and ends; its legs are numbered as they are played. Behind the line
stands the curvature of the connection, one function for each way the base can move: a small loop moves the base by
the curvature over its inside, taken as it is if the loop runs anticlockwise and with the other sign if clockwise. So
loops that run in the same sense over one colour of a panel add up there; if they run in opposite senses over it, or
in the same over opposite colours, they cancel. The dashed line is where the curvature is zero. For large loops this
is a guide and not the answer, since the base turns on its way; the numbers given are those of the exact flow.

Limb 1 is blue, limb 2 orange, the base black. The colours are safe for people who see few of them. In one cycle, with
the way to its first shape and back where that is not the collinear one:
"""
_PRINTED = """\
## What the printed sequences really do

Section V-C of the paper prints a sequence of flows for each of the six motions. They are stored word for word as
`printed-x` to `printed-phi`. In the paper's own frames they do this in one cycle, at 1 rad:
"""
_WHY = """\
The planar sources count the angle of link 2 with the other sign. A loop that is meant for one quadrant of the shape
plane then lies in its neighbour, where the other motion is made. The sequence for y runs its two loops through the
quadrants in which the yaw curvature is strong, of one sign in each, and in opposite senses, so that both turn the
base the same way; what they advance along x cancels:
"""
_WHY_PSI = """\
The loops of the sequence for psi lie evenly about the line on which both angles are equal, across which the yaw
curvature is odd. Nothing is left of the turn, and what adds up is the translation along y:
"""
_END = """\
The sequence for x is a single loop: it advances, and what it drifts sideways nothing takes back. The sequences for z
and theta are those for y and psi rolled by a quarter turn onto the pitch joints, with the same fault. The sequence
for phi is one roll of one limb, which the rest of the swimmer answers by rolling the other way by a third of it; the
limb stays rolled, so the sequence is not closed. The project's own gaits do what they are called, and come back to
the collinear shape.
"""


@dataclass(frozen=True)
class Shown:
    """A gait of the page, and what one cycle of it does for the paper's swimmer."""

    gait: Gait
    stroke: Stroke
    moved: tuple[float, ...]

    @classmethod
    def named(cls, name: str) -> Shown:
        """Return the gait with a name, at its default amplitude."""
        swimmer, gait = Swimmer(), stored_gaits()[name]
        stroke = realise(gait, swimmer)
        g = stroke.displacement(swimmer)
        return cls(gait, stroke, (*(g[:3, 3] / swimmer.length_m), *np.degrees(as_euler(g[:3, :3]))))

    def row(self) -> str:
        """Return a line of a table: name, joint travel, and what it does."""
        cells = [f"{value:.4f}" if abs(value) >= 5e-5 else "0" for value in self.moved[:3]]
        cells += [f"{value:.2f}" if abs(value) >= 5e-3 else "0" for value in self.moved[3:]]
        closed = "yes" if self.stroke.closure_rad() < 1e-9 else "no"
        return f"| `{self.gait.name}` | {self.stroke.played().joint_travel_rad:.3f} | {' | '.join(cells)} | {closed} |"


def table(names: tuple[str, ...]) -> str:
    """Return what some gaits do, as a table."""
    head = "| gait | joint travel [rad] | x [L] | y [L] | z [L] | yaw [°] | pitch [°] | roll [°] | closed |"
    return "\n".join([head, f"|{' --- |' * 9}", *(Shown.named(name).row() for name in names)])


def picture(name: str, kind: str, what: str) -> str:
    """Return the line that shows a picture."""
    return f"![{what}](../pictures/{name}-{kind}.svg)"


def page() -> str:
    """Return the text of the page."""
    parts = [_HEAD, f"{table(SHOWN)}\n"]
    for name in SHOWN:
        summary = stored_gaits()[name].summary
        parts += [
            f"## {name}\n\n{summary[0].upper()}{summary[1:]}.\n",
            f"{picture(name, 'stroke', f'{name} over the curvature of its shapes')}\n",
            f"{picture(name, 'poses', f'the swimmer where the controls of {name} switch')}\n",
        ]
    seen = [f"{picture(name, 'stroke', f'{name} over the curvature of its shapes')}\n" for name in CONTRASTS]
    parts += [_PRINTED, f"{table(PRINTED)}\n", _WHY, seen[0], _WHY_PSI, seen[1], _END]
    return "\n".join(parts)


def draw(name: str, kinds: tuple[str, ...]) -> None:
    """Draw the pictures of a gait."""
    from purcell_cli.gaits.sampling import sample_stroke
    from purcell_cli.pictures.poses_plot import poses_figure
    from purcell_cli.pictures.stroke_plot import stroke_figure
    from purcell_cli.pictures.style import make_folder, save_figure

    makers = {"stroke": stroke_figure, "poses": poses_figure}
    shown, swimmer = Shown.named(name), Swimmer()
    trajectory = sample_stroke(swimmer, Configuration(), shown.stroke, 1, _SMOOTH_S)
    make_folder(PICTURES)
    for kind in kinds:
        title = f"{name}, amplitude {shown.stroke.amplitude_rad:g} rad"
        save_figure(makers[kind](swimmer, trajectory, title), PICTURES / f"{name}-{kind}.svg")


def main() -> None:
    """Write the page and its pictures."""
    PAGE.write_text(page(), encoding="utf-8")
    for name in SHOWN:
        draw(name, ("stroke", "poses"))
    for name in CONTRASTS:
        draw(name, ("stroke",))


if __name__ == "__main__":
    main()
