"""The certificate: a plan integrated anew by another method, and the verdict on it.

Uses nothing that made the plan: neither `gaits`, `planner` nor the lift. Imports `motion`, `mechanics`, `geometry`.
"""
