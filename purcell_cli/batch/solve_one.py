"""One scenario solved: its row of the summary and the bytes of its files. This is what runs on every worker."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import io
import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import cast

from purcell_cli import __version__
from purcell_cli.batch.rows import CRASHED, NUMBERS, Numbers, Result, RowVerdict
from purcell_cli.errors import PurcellError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.files.gait_file import gait_text
from purcell_cli.files.place import shortened
from purcell_cli.files.plan_file import PlanDocument
from purcell_cli.files.scenario_file import Scenario
from purcell_cli.files.trajectory_csv import write_rows
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.gait import Gait
from purcell_cli.missions import plan_mission
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.verdict import Verdict
from purcell_cli.solution import Solution, stroke_cycles


@frozen_dataclass
class Settings:
    """How all scenarios of a batch are solved.

    Attributes:
        options: What is asked of every plan; the workspace and the obstacles are the scenario's own.
        trajectories: Whether trajectories are written.
        gaits: The gaits of the user's own, which are added to those of the package; None where there are none.
        folder: Where results go, from which plan documents name the files of meshes; no result depends on it.
    """

    options: PlanOptions = PlanOptions()
    trajectories: bool = True
    gaits: Mapping[str, Gait] | None = None
    folder: Path | None = None

    def fingerprint(self) -> str:
        """Return a text that changes with anything that results depend on."""
        gaits = None if self.gaits is None else [(name, gait_text(gait)) for name, gait in self.gaits.items()]
        return repr((_program(), self.options, self.trajectories, gaits))


@functools.cache
def _program() -> str:
    """Return a digest of this package: another version of it may plan otherwise, and be half way to the next."""
    package = Path(__file__).resolve().parent.parent
    found = hashlib.sha256(__version__.encode())
    for path in sorted((*package.rglob("*.py"), *package.rglob("*.json"))):
        found.update(path.read_bytes())
    return found.hexdigest()


@frozen_dataclass
class Solved:
    """What came of a scenario.

    Attributes:
        row: Verdict, error, `NUMBERS` and the time taken; None for what there is not.
        files: What its files hold, by ending.
    """

    row: Result
    files: dict[str, bytes] = dataclasses.field(default_factory=dict)


def without_plan(verdict: RowVerdict, error: str, wall_time_s: float = 0.0) -> Solved:
    """Return what came of a scenario that has no plan."""
    nothing = cast(Numbers, dict.fromkeys(NUMBERS))
    return Solved({"verdict": verdict, "error": error, **nothing, "wall_time_s": wall_time_s})


def solve(scenario: Scenario, settings: Settings) -> Solved:
    """Plan a scenario's motion and make its files; whatever goes wrong is told in the result.

    Args:
        scenario: The scenario.
        settings: How to solve it.
    """
    begun = time.perf_counter()
    try:
        solution = plan_mission(
            scenario.mission,
            swimmer=scenario.swimmer,
            options=dataclasses.replace(settings.options, workspace=scenario.workspace, obstacles=scenario.obstacles),
            gaits=None if settings.gaits is None else {**stored_gaits(), **settings.gaits},
        )
        numbers, files = _numbers(solution), _files(solution, settings)
    except PurcellError as error:
        return without_plan(Verdict.ERROR, str(error), time.perf_counter() - begun)
    except Exception as error:  # a fault of one scenario must not stop the others
        return without_plan(CRASHED, shortened(f"{type(error).__name__}: {error}", 1000), time.perf_counter() - begun)
    lasted = time.perf_counter() - begun
    blocked = solution.plan.blocked
    why = None if blocked is None else f"no way round obstacles: {blocked.words}"
    return Solved({"verdict": solution.verdict, "error": why, **numbers, "wall_time_s": lasted}, files)


def _files(solution: Solution, settings: Settings) -> dict[str, bytes]:
    document = PlanDocument(solution.plan, solution.options)
    files = {".json": document.as_text(settings.folder).encode()}
    if settings.trajectories:
        stream = io.BytesIO()
        write_rows(solution.trajectory, stream)
        files[".csv"] = stream.getvalue()
    return files


def _numbers(solution: Solution) -> Numbers:
    found, length = solution.certificate.deviation, solution.plan.swimmer.length_m
    blocks = solution.plan.blocks
    strokes = (blocks[part] for part in solution.strokes if blocks[part][0].phase == 2)
    bend = solution.limits.largest_bend_rad[1]
    numbers: Numbers = {
        "joint_travel_rad": float(solution.joint_travel_rad),
        "duration_s": float(solution.duration_s),
        "energy_j": float(solution.energy_j.sum()),
        "position_error_over_L": float(found.position_m / length),
        "base_error_rad": float(found.base_rad),
        "limb1_error_rad": float(found.limb1_rad),
        "limb2_error_rad": float(found.limb2_rad),
        "clearance_m": float(solution.limits.clearance.distance_m),
        "largest_bend_rad": None if bend is None else float(bend),
        "primitives": int(solution.plan.primitives),
        "cycles": sum(stroke_cycles(stroke) for stroke in strokes),
        "rows": len(solution.trajectory),
    }
    if not all(math.isfinite(cast(float, number)) for number in numbers.values() if number is not None):
        raise ArithmeticError("a number of the plan that is not finite")
    return numbers
