"""Whether a scenario came to what it must: against its own `expect`, and against an earlier run."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Set
from pathlib import Path
from typing import Any

from purcell_cli.errors import InputError, ParameterError
from purcell_cli.files.paths import UnreadableError, readable
from purcell_cli.files.scenario_file import Expect
from purcell_cli.files.used_files import note_input
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.motion.verdict import Verdict
from purcell_cli.wording import counted

ERRORS = ("position_error_over_L", "base_error_rad", "limb1_error_rad", "limb2_error_rad")
"""The errors of a row: the base's position in units of L, and three angles [rad]."""

ROUND_OFF = 1e-10
"""Errors below this are round-off, which differs between machines and says nothing about a plan."""

_ANGLES = {"base_error_rad": "base", "limb1_error_rad": "limb 1", "limb2_error_rad": "limb 2"}
_MOST_BYTES = 1 << 30
"""Bytes of an earlier summary at most: a row has about 600, so this is more than a million scenarios."""


_PART = re.compile(r"\+?(?P<number>(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?) ?(?P<sign>%?)")
"""A fraction, or a percentage with its sign."""

Row = Mapping[str, Any]


def shortfalls(expect: Expect, row: Row) -> list[str]:
    """Return what of an expectation a result does not hold, one sentence each; none if it holds.

    Args:
        expect: What the scenario must come to.
        row: Its row of the summary.
    """
    out = []
    if row["verdict"] != expect.verdict:
        because = f" ({row['error']})" if row["error"] else ""
        out.append(f"verdict: wanted {expect.verdict}, found {row['verdict']}{because}")
    elif expect.error is not None and expect.error not in (row["error"] or ""):
        out.append(f"error: wanted a message with {expect.error!r}, found {row['error']!r}")
    if row["joint_travel_rad"] is None:
        return out
    at_most = [
        ("position error", "position_error_over_L", expect.position_tolerance, "L"),
        *((f"{name} error", key, expect.angle_tolerance_rad, "rad") for key, name in _ANGLES.items()),
        ("joint travel", "joint_travel_rad", expect.max_joint_travel_rad, "rad"),
        ("duration", "duration_s", expect.max_duration_s, "s"),
    ]
    out += [
        f"{name}: wanted at most {most:.6g} {unit}, found {row[key]:.6g} {unit}"
        for name, key, most, unit in at_most
        if most is not None and not row[key] <= most
    ]
    least, clearance = expect.min_clearance_m, row["clearance_m"]
    if least is not None and clearance is not None and not clearance >= least:
        out.append(f"clearance: wanted at least {least:.6g} m, found {clearance:.6g} m")
    return out


@frozen_dataclass
class Baseline:
    """An earlier run to compare with.

    Attributes:
        rows: Its rows of the summary by name.
        most: By which fraction a number may be larger now.
    """

    rows: Mapping[str, Row]
    most: float

    def vanished(self, names: Set[str], wanted: Callable[[str], bool] = lambda _: True) -> list[str]:
        """Return the scenarios of the earlier run that a batch has not.

        Args:
            names: The names of the batch's scenarios.
            wanted: Whether a name is asked for.

        Raises:
            InputError: The batch has none of them, so that there is nothing to compare.
        """
        if not self.rows.keys() & names:
            known = f"{counted(len(self.rows), 'scenario')} of other names"
            raise InputError(f"--baseline: wanted an earlier run with a scenario of this batch, found {known}")
        return [name for name in self.rows if name not in names and wanted(name)]

    def regressions(self, name: str, row: Row) -> list[str]:
        """Return what is worse now, one sentence each; none where the earlier run has no such scenario."""
        before = self.rows.get(name)
        if before is None:
            return []
        if row["verdict"] != before["verdict"]:
            worse = before["verdict"] == Verdict.REACHED
            return [f"regression: verdict {row['verdict']}, reached in the baseline"] if worse else []
        out = []
        for key in ("joint_travel_rad", *ERRORS):
            now, then = row[key], before[key]
            if now is None or then is None:
                continue
            least = 0.0 if key == "joint_travel_rad" else ROUND_OFF
            if now > max(then * (1.0 + self.most), least):
                more = f"{100.0 * (now / then - 1.0):.3g} % more than" if then > 0.0 else "above"
                out.append(f"regression: {key} {now:.6g}, {more} the baseline's {then:.6g}")
        return out


def load_baseline(path: Path | str, most: float) -> Baseline:
    """Return the earlier run that a summary.json tells of.

    Args:
        path: The file.
        most: By which fraction a number may be larger now.

    Raises:
        InputError: The file is no summary of a batch.
    """
    source = Path(path)
    try:
        if readable(source).st_size > _MOST_BYTES:
            raise ValueError("a file that is too large for one")
        note_input(source)
        summary = json.loads(source.read_text(encoding="utf-8-sig"))
        rows = {row["name"]: row for row in summary["rows"]}
        for row in rows.values():
            if not isinstance(row["verdict"], str):
                raise TypeError("a verdict that is no text")
            for key in ("joint_travel_rad", *ERRORS):
                if row[key] is not None:
                    float(row[key] + 0.0)
    except (UnreadableError, OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        found = f"no key {error}" if isinstance(error, KeyError) else error
        raise InputError(f"{source}: wanted the summary.json of a batch, found {found}") from error
    return Baseline(rows, most)


def fraction(text: str) -> float:
    """Return a fraction that is written as 5% or 0.05; above 1 it needs the sign.

    Raises:
        ParameterError: The text is neither.
    """
    found = _PART.fullmatch(text.strip())
    value = float(found["number"]) / (100.0 if found["sign"] else 1.0) if found else -1.0
    if not 0.0 <= value < 1e6:
        raise ParameterError(f"--max-regress: a part such as 5% or 0.05 is wanted, found {text!r}")
    if found and not found["sign"] and value > 1.0:
        hint = f"{text.strip()}% or {value / 100.0:g}"
        raise ParameterError(
            f"--max-regress: a part of at most 1, or a percentage with its sign ({hint}), is wanted, "
            f"found {text!r}, which would be {100.0 * value:g} %"
        )
    return value
