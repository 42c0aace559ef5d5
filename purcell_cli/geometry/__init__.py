"""Rotations, rigid motions and the layout of arrays (appendix B of the paper).

Holds SO(3), SE(3) and component-first arrays. Imports nothing of the package but `errors` and `wording`.
"""
