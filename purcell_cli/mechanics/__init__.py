"""The swimmer, its drag and how shape changes move it (sections II, III and V-A of the paper).

Holds the swimmer, the local connection and the lift of shape paths to SE(3). Imports `geometry`.
"""
