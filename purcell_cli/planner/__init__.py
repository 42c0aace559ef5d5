"""Planning: from a start configuration to a goal configuration (section IV-B of the paper).

Holds the three phases: `limbs`, `arcs` and `library` propose motions, `refine` brings them to the goal.
Imports `gaits`, `motion`, `lie_brackets`, `mechanics` and `geometry`.
"""
