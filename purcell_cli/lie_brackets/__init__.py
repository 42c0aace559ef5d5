"""Control fields, their brackets, curvature and controllability (section IV-A and appendix A of the paper).

Says which directions small shape loops move the swimmer in. Imports `mechanics` and `geometry`.
"""
