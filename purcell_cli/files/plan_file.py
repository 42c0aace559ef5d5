"""Plan documents: a plan as one JSON file, from which the very same motion can be played again.

Numbers are written so that they read back bit for bit, and rotations as matrices, which come back
as they are; so a plan that is read makes the same trajectory, byte by byte. What is read is
checked like every other input, by one description of the whole document.
"""

from __future__ import annotations

import itertools
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from purcell_cli import __version__
from purcell_cli.errors import InputError, refuse_types
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.files.containers import Field, ListOf, Pair, Record
from purcell_cli.files.documents import Document, Made
from purcell_cli.files.option_elements import OPTION_FIELDS, options_read, options_written
from purcell_cli.files.paths import is_file
from purcell_cli.files.place import Place
from purcell_cli.files.plan_way import WAY_FIELDS, way_written
from purcell_cli.files.scalars import Choice, Number, Text, Whole
from purcell_cli.files.scenario_file import SCHEMAS
from purcell_cli.files.swimmer_file import swimmer_written
from purcell_cli.files.yaml_source import load
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import INPUT_SLACK
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.moves import ControlSequence, MoveSequence
from purcell_cli.mechanics.primitives import PRIMITIVE_NAMES, PrimitiveSequence
from purcell_cli.motion.blocks import Block, with_joint_rates
from purcell_cli.motion.memory import MOST_ROWS
from purcell_cli.motion.mission import Passage
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.plan import Plan

SCHEMA = "purcell/plan-document/1"
"""The name of the form that plan documents have."""

_REPORT = rb'{\s*"schema":\s*"purcell/(plan|run|replan)/'
"""How what commands print of plans begins, which says nothing of how to play them."""

_LARGEST_ANGLE_RAD = 10.0
"""Largest turn of a joint in one primitive or move [rad]: more than a whole turn, which no plan needs in one go.

The sine of a much larger angle, far outside [-pi, pi], would lose digits."""

_BEGIN_BYTES = 256
"""Bytes at the beginning of a plan document in which the name of its form stands."""

_MOST_CYCLES = 1_000_000_000
"""Times that a stroke may be played at most: far above `MOST_ROWS`, which bounds the motion, and exact as a double."""


@frozen_dataclass(eq=False)
class PlanDocument:
    """A plan and what else its trajectory depends on.

    Attributes:
        plan: The plan.
        options: What was asked of it: the limits it keeps, how its trajectory is sampled, and how it was looked for.
        version: The version of this package that made the plan; what it did is in the plan itself.
    """

    plan: Plan
    options: PlanOptions = PlanOptions()
    version: str = __version__

    def as_text(self, folder: Path | None = None) -> str:
        """Return the document as JSON, a line for each stroke.

        Args:
            folder: Where it will be, from which the files of meshes are then named; they are named in full without one.
        """
        plan = self.plan
        head = {
            "schema": SCHEMA,
            "purcell": self.version,
            "swimmer": swimmer_written(plan.swimmer),
            "start": _configuration(plan.start),
            "goal": _configuration(plan.goal),
            **options_written(self.options, folder),
            **way_written(plan.passages, plan.follow),
        }
        lines = [f"  {_json(key)}: {_json(value)}" for key, value in head.items()]
        blocks = ",\n".join(f"    {_json(_block(block))}" for block in plan.blocks)
        lines.append(f'  "blocks": [\n{blocks}\n  ]' if blocks else '  "blocks": []')
        return "{\n" + ",\n".join(lines) + "\n}\n"


def _json(value: object) -> str:
    return json.dumps(value, allow_nan=False)


def _configuration(configuration: Configuration) -> dict[str, Any]:
    pose, limbs = configuration.pose, configuration.shape.tolist()
    return {
        "base": {"position_m": pose[:3, 3].tolist(), "orientation": {"matrix": pose[:3, :3].tolist()}},
        "limb1": {"matrix": limbs[0]},
        "limb2": {"matrix": limbs[1]},
    }


def _block(block: Block) -> dict[str, Any]:
    amplitude = {} if math.isnan(block.amplitude_rad) else {"amplitude_rad": block.amplitude_rad}
    return {
        "phase": block.phase,
        "gait": block.gait,
        **amplitude,
        "cycles": block.cycles,
        **_controls(block.sequence),
    }


def _controls(sequence: ControlSequence) -> dict[str, Any]:
    if isinstance(sequence, PrimitiveSequence):
        return {"primitives": list(sequence)}
    return {"moves": [list(m) for m in zip(sequence.rates().tolist(), sequence.duration.tolist(), strict=True)]}


def _controls_read(value: dict[str, Any], place: Place) -> ControlSequence:
    if ("primitives" in value) == ("moves" in value):
        raise place.error("exactly one of the keys primitives, moves", "both" if "moves" in value else "none of them")
    if "primitives" in value:
        return PrimitiveSequence.of(value["primitives"])
    rates = np.array([rate for rate, _ in value["moves"]]).reshape(-1, 6)
    return MoveSequence(rates, np.array([duration for _, duration in value["moves"]]))


def _block_read(value: dict[str, Any], place: Place) -> Block:
    sequence = _controls_read(value, place)
    if value["cycles"] > 1:
        off = float(np.max(np.abs(sequence.shapes(COLLINEAR)[-1] - COLLINEAR)))
        if off > INPUT_SLACK:
            wanted = "1 for a stroke that does not bring the limbs back to where they were"
            raise place.at("cycles").error(wanted, f"{value['cycles']} (they are off by {off:.2g})")
    return Block(value["phase"], value["gait"], sequence, value["cycles"], value.get("amplitude_rad", math.nan))


def _plan_read(value: dict[str, Any], place: Place) -> PlanDocument:
    blocks: list[Block] = value["blocks"]
    passages: list[Passage] = value.get("via", [])
    begun = {passage.block for passage in passages}
    for k, (before, after) in enumerate(itertools.pairwise(blocks), start=1):
        if after.phase < before.phase and k not in begun:
            wanted = f"a phase of at least {before.phase}, that of the stroke before"
            raise place.at("blocks", k, "phase").error(wanted, str(after.phase))
    for k, passage in enumerate(passages):
        fewest = passages[k - 1].block if k else 0
        if not fewest <= passage.block <= len(blocks):
            wanted = f"a number of blocks from {fewest} to {len(blocks)}"
            raise place.at("via", k, "block").error(wanted, str(passage.block))
    ends = value["swimmer"], value["start"], value["goal"]
    known = with_joint_rates(value["swimmer"], value["start"].shape, blocks)
    plan = Plan(*ends, known, passages=tuple(passages), follow=value.get("follow"))
    if plan.primitives > MOST_ROWS:
        raise place.at("blocks").error(f"at most {MOST_ROWS:.0e} primitives", f"{plan.primitives}")
    options = options_read(value)
    if plan.duration_s / options.dt_s > MOST_ROWS:
        least = f"a time above {plan.duration_s / MOST_ROWS:.2g} s (at most {MOST_ROWS:.0e} rows)"
        raise place.at("dt_s").error(least, f"{options.dt_s!r}")
    return PlanDocument(plan, options, value["purcell"])


_BLOCK = Record(
    {
        "phase": Field(Whole(1, 3), "1, 2 or 3 of the reconfiguration", required=True),
        "gait": Field(
            Text(r"[A-Za-z0-9_-][A-Za-z0-9 ._-]{0,99}", "a stroke's name (letters, digits, ' ', '-', '_' and '.')"),
            "name of the stroke",
            required=True,
        ),
        "amplitude_rad": Field(Number(), "amplitude of the stroke, where it has one [rad]"),
        "cycles": Field(Whole(1, _MOST_CYCLES), "how often it is played", required=True),
        "primitives": Field(
            ListOf(Pair(Choice(PRIMITIVE_NAMES), Number(at_least=-_LARGEST_ANGLE_RAD, at_most=_LARGEST_ANGLE_RAD))),
            "control and angle [rad] of each primitive of one cycle",
        ),
        "moves": Field(
            ListOf(
                Pair(
                    ListOf(Number(at_least=-1.0, at_most=1.0), length=6),
                    Number(at_least=0.0, at_most=_LARGEST_ANGLE_RAD),
                )
            ),
            "instead, the six controls and the duration [s] of each move of one cycle, at a joint rate of 1 rad/s",
        ),
    }
)

PLAN = Document(
    "A plan",
    Made(
        Record(
            {
                "schema": Field(Choice((SCHEMA,)), "the form of the document", required=True),
                "purcell": Field(Text(r"[^\n]{1,100}", "a version"), "the version that made the plan", required=True),
                "swimmer": Field(SCHEMAS["swimmer"], "who swims", required=True),
                "start": Field(SCHEMAS["start"], "where it starts", required=True),
                "goal": Field(SCHEMAS["start"], "where it is to end", required=True),
                **OPTION_FIELDS,
                **WAY_FIELDS,
                "blocks": Field(ListOf(Made(_BLOCK, _block_read)), "the strokes, in order", required=True),
            }
        ),
        _plan_read,
    ),
)
"""The description that reads a plan document and prints itself as JSON Schema."""


def is_plan(path: Path | str) -> bool:
    """Return whether a file is a plan document, by its first lines."""
    begun = _beginning(path)
    return begun.startswith(b"{") and f'"{SCHEMA}"'.encode() in begun


def _beginning(path: Path | str) -> bytes:
    """Return a file's first bytes, none where it cannot be read, or only once, as a pipe."""
    if not is_file(path):
        return b""
    try:
        with Path(path).open("rb") as stream:
            return stream.read(_BEGIN_BYTES).lstrip()
    except (OSError, ValueError):
        return b""


def write_plan(document: PlanDocument, path: Path | str) -> None:
    """Write a plan document.

    Args:
        document: The plan.
        path: The file; it is replaced only when all is written.

    Raises:
        InputError: The file cannot be written.
        ParameterError: What is no plan document.
    """
    refuse_types(document=(document, PlanDocument))
    with whole_file(path) as stream:
        stream.write(document.as_text(Path(path).parent).encode())


def load_plan(path: Path | str) -> PlanDocument:
    """Return the plan of a document; the path - is standard input.

    Raises:
        InputError: The file says no plan.
    """
    if re.match(_REPORT, _beginning(path)):
        raise InputError(f"{path}:1: wanted a plan document, as --plan-out writes it, found what --json prints")
    return load(path, PLAN)
