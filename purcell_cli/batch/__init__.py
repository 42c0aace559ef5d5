"""Many scenarios at once: found, expanded, solved by several workers, judged, and kept so that nothing is lost.

Imports everything below; nothing imports it but the command line.
"""
