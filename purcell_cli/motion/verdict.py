"""How the planning of a motion can end."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal


class Verdict(StrEnum):
    """How a plan, or a scenario, can end; only `REACHED` is success."""

    REACHED = "reached"
    NOT_REACHED = "not reached"
    NOT_WITHIN_LIMITS = "not found within limits"
    ERROR = "error"


PlanVerdict = Literal[Verdict.REACHED, Verdict.NOT_REACHED, Verdict.NOT_WITHIN_LIMITS]
"""How a plan that there is can end."""
