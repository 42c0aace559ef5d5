"""Makes what the package keeps ready so that a command starts sooner: stored gaits as JSON, tables of the planner.

python tools/prepare_tables.py

It is run when a gait, a library plan or the flow changes; a test says when that was forgotten.
"""

from __future__ import annotations

from typing import Any
from unittest import mock

import numpy as np

from purcell_cli.files import gaits_as_json
from purcell_cli.files.builtin import data_folder, own_gaits
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift import run_displacements
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner import prepared
from purcell_cli.planner.arcs import loops
from purcell_cli.planner.library import plan_library


def tables() -> dict[str, Array]:
    """Return the tables of the paper's swimmer, computed, by the names of their files."""
    found = {}

    def computed(table: str, swimmer: Swimmer, pieces: Any, counts: Any, accuracy: Any) -> Array:
        file = prepared.file_of(table, swimmer, pieces, counts, accuracy)
        found[file.name] = run_displacements(swimmer, pieces, counts, np.ones_like(counts), accuracy)
        return found[file.name]

    unit = Swimmer().scaled()
    with (
        mock.patch.object(loops, "run_displacements_kept", computed),
        mock.patch.object(plan_library, "run_displacements_kept", computed),
    ):
        plan_library.MotionLibrary(plan_library.stored_plans(), unit)
        for across in (False, True):
            loops.Loops(unit, "travel", across)
    return found


def main() -> None:
    """Write all of it."""
    folder = data_folder("gaits")
    text = gaits_as_json.json_text(own_gaits(folder), folder)
    (folder / gaits_as_json.NAME).write_text(text, encoding="utf-8", newline="\n")
    prepared.FOLDER.mkdir(exist_ok=True)
    for old in prepared.FOLDER.glob("*.npy"):
        old.unlink()
    for name, table in tables().items():
        np.save(prepared.FOLDER / name, table.astype("<f8"))


if __name__ == "__main__":
    main()
