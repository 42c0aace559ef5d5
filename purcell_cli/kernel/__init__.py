"""The compiled kernel: elementary functions, small matrices, local connection (III-C), the flow and its derivatives.

C sources, the library built from them, and checked calls from arrays. Imports nothing of the package.
"""
