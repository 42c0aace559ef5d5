"""The colours of all pictures, told apart by every eye (Okabe and Ito's)."""

from __future__ import annotations

BLUE, ORANGE, GREEN, PINK, BLACK, GREY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#222222", "#666666"

AMBER = "#E69F00"
"""The colour of a mission: its waypoints, or its curve."""
