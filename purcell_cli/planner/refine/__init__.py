"""Refinement of a motion that almost arrives: exact arrival, minimum travel, minimum time.

Single shooting over segments with linear constraints. Part of the planner.
"""
