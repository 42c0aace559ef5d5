"""Environment: what stands in the water, and how far segments are from it.

Beyond the paper, which knows empty water alone. It may import the geometry and the kernel.
"""
