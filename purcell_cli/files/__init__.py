"""Everything that is read or written: configurations, swimmers, gaits, scenarios, plans and trajectories.

Checks what it reads, with file, line and key, and replaces files whole. Imports everything below.
"""
