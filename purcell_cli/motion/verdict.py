"""How the planning of a motion can end."""

from __future__ import annotations

from enum import StrEnum


class Verdict(StrEnum):
    """How a plan, or a scenario, can end; only `REACHED` is success."""

    REACHED = "reached"
    NOT_REACHED = "not reached"
    NOT_WITHIN_LIMITS = "not found within limits"
    ERROR = "error"
