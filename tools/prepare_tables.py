"""Makes what the package keeps ready so that a command starts sooner: stored gaits as JSON, tables of the planner.

python tools/prepare_tables.py

It is run when a gait, a library plan or the flow changes; a test says when that was forgotten.
"""

from __future__ import annotations

import numpy as np

from purcell_cli.files import gaits_as_json
from purcell_cli.files.builtin import data_folder, own_gaits, stored_gaits
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner import prepared
from purcell_cli.planner.arcs.loops import Loops
from purcell_cli.planner.arcs.roll_stroke import RollStroke, rolling
from purcell_cli.planner.gait_sequence import StrokeBook
from purcell_cli.planner.library.plan_library import MotionLibrary, stored_plans


def tables() -> dict[str, Array]:
    """Return the tables of the paper's swimmer, computed, by the names of their files."""
    gaits, unit = stored_gaits(), Swimmer().scaled()
    with prepared.recorded() as found:
        MotionLibrary(stored_plans(), unit)
        for across in (False, True):
            Loops(unit, "travel", across)
        StrokeBook(gaits.values(), unit)
        for gait in rolling(gaits):
            RollStroke(gait, unit)
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
