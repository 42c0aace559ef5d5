"""Plans for swimmers on hinges, universal joints and fixed limbs: the ways in and out, loops, and chains of them
(section IV-B of the paper with other joints).

May import what `planner` may.
"""
