"""Plans for swimmers on hinges, universal joints and fixed limbs (section IV-B of the paper with other joints).

Ways in and out, loops of two joint angles, and chains of them. May import what `planner` may.
"""
