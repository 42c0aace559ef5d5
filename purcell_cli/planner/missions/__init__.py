"""Missions: the poses and the order of waypoints that cost least, and the legs between them.

Prices legs as needles are steered. Part of the planner; may import `arcs` and what is below the planner.
"""
