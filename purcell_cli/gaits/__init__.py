"""Stored gaits, closed shape curves, the atlas and the gait designer (sections V-B and V-C of the paper).

Says what a gait is and finds its free angles. Imports `motion`, `lie_brackets`, `mechanics` and `geometry`.
"""
