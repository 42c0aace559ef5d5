"""Phases 1 and 3: limbs to the collinear shape and to the goal shape (section IV-B of the paper).

Lists ways to straighten the limbs and what each does to the base. Part of the planner.
"""
