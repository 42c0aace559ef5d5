"""The command line: parse, load, call the library, show; one command a file.

Thin on purpose: documents and tables are made in `reports`. Imports everything below.
"""

import gc

_OBJECTS_BEFORE_COLLECTION = 200_000
"""New objects before garbage is looked for: importing makes some 70,000, none of them garbage, and plans hold their
numbers in arrays, which go without; looking took 50 ms of a start."""

gc.set_threshold(_OBJECTS_BEFORE_COLLECTION)
