"""Plots and the HTML page of trajectories, gaits and controllability.

Draws what the rooms below have computed and computes nothing itself. Imports everything below.
"""
