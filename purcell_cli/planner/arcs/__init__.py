"""Rolls and circular arcs by repeated shape loops, for far goals.

Steers the swimmer as a needle is steered and fits chains of loops to the way. Part of the planner.
"""
