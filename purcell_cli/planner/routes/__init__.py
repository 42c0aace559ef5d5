"""Ways round obstacles: a roadmap of collinear poses, and the exact legs along its cheapest path.

Beyond the paper. Part of the planner; may import `arcs`, `reconfiguration` and what is below the planner.
"""
