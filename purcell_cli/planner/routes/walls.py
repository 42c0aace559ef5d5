"""A workspace's walls as obstacles, for the search."""

from __future__ import annotations

from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import HalfSpace
from purcell_cli.motion.workspace import Workspace


def with_walls(scene: Scene, workspace: Workspace | None) -> Scene:
    """Return a scene with a half space behind each wall of a workspace, if there is one."""
    if workspace is None:
        return scene
    walls = []
    for sign, corner in ((1.0, workspace.min), (-1.0, workspace.max)):
        for axis, place in enumerate(corner):
            if place is not None:
                at, normal = [0.0] * 3, [0.0] * 3
                at[axis], normal[axis] = place, sign
                walls.append(HalfSpace((at[0], at[1], at[2]), (normal[0], normal[1], normal[2])))
    return Scene((*scene.obstacles, *walls))
