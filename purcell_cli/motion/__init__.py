"""Motions in time: strokes one after the other, sampled trajectories, clearance and limits.

Holds what a plan is made of and what is checked over all of it. Imports `mechanics` and `geometry`.
"""
