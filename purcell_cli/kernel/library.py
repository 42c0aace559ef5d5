"""The compiled library: found, checked and loaded, and what its functions take.

It is built when the package is installed (`hatch_build.py`), never when it runs.
"""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path

from purcell_cli.kernel.sources import digest, file_name, sources

HERE = Path(__file__).resolve().parent
FILE = HERE / file_name(sys.platform)
"""The library, beside this module."""

_SIZE, _ARRAY, _NUMBER = ctypes.c_int64, ctypes.c_void_p, ctypes.c_double
_RULE = [_ARRAY, _SIZE, _ARRAY, _ARRAY, _ARRAY, _NUMBER, _NUMBER, _SIZE]
"""The swimmer, the collocation's rule, step and tolerance, and how many pieces there are."""
_MOTION = [*_RULE, _SIZE, *[_ARRAY] * 3, _SIZE, _ARRAY, _SIZE, *[_ARRAY] * 7]
_MOTION += [_NUMBER, *[_ARRAY] * 2, *[_NUMBER] * 2, *[_SIZE] * 2, *[_ARRAY] * 6]
"""Those, and a motion whose angles are looked for; see `descent.c`."""
_APART = [*[_ARRAY] * 6, _SIZE, _NUMBER, *[_ARRAY] * 3]
"""A search for the least distance between limbs; see `clearance.c`."""
_SIGNATURES: dict[str, tuple[type[ctypes.c_int64 | ctypes.c_double] | None, list[type]]] = {
    "sine": (_NUMBER, [_NUMBER]),
    "cosine": (_NUMBER, [_NUMBER]),
    "angle": (_NUMBER, [_NUMBER, _NUMBER]),
    "sin_cos": (None, [_SIZE, _ARRAY, _ARRAY, _ARRAY]),
    "arctan2": (None, [_SIZE, _ARRAY, _ARRAY, _ARRAY]),
    "exp_coefficients": (None, [_SIZE, _ARRAY, _ARRAY]),
    "products": (None, [*[_SIZE] * 4, _ARRAY, _SIZE, _ARRAY, _SIZE, _ARRAY]),
    "solve": (None, [*[_SIZE] * 3, *[_ARRAY] * 2]),
    "orthogonal_rows": (_SIZE, [*[_SIZE] * 2, _ARRAY, _NUMBER, *[_ARRAY] * 2]),
    "inner": (None, [_SIZE, _SIZE, *[_ARRAY] * 3]),
    "cross": (None, [_SIZE, *[_ARRAY] * 3]),
    "least_steps": (None, [_SIZE, _SIZE, *[_ARRAY] * 8]),
    "bead_resistance": (_SIZE, [_SIZE, *[_ARRAY] * 7]),
    "looked_up": (None, [_ARRAY, _SIZE, *[_ARRAY] * 2]),
    "segments": (None, [_SIZE, *[_ARRAY] * 4]),
    "circles": (None, [_SIZE, *[_ARRAY] * 6]),
    "largest_bends": (None, [_SIZE, *[_ARRAY] * 7]),
    "clearance_begun": (_SIZE, [_SIZE, *_APART, _ARRAY]),
    "clearance_cut": (_SIZE, [_SIZE, *_APART, _ARRAY, _SIZE, *[_ARRAY] * 2]),
    "clearance_rooms": (_SIZE, [_SIZE, *[_ARRAY] * 5, *[_NUMBER] * 2, *[_ARRAY] * 5]),
    "from_balls": (None, [_SIZE, *[_ARRAY] * 2, _SIZE, *[_ARRAY] * 4]),
    "from_boxes": (None, [_SIZE, *[_ARRAY] * 2, _SIZE, *[_ARRAY] * 3, _SIZE, *[_ARRAY] * 2]),
    "from_triangles": (None, [_SIZE, *[_ARRAY] * 3, *[_SIZE] * 2, *[_ARRAY] * 3]),
    "inside_cones": (None, [_SIZE, *[_ARRAY] * 2, *[_SIZE] * 2, *[_ARRAY] * 7]),
    "program": (_SIZE, [*[_SIZE] * 4, _NUMBER, *[_ARRAY] * 9]),
    "convex": (_SIZE, [*[_SIZE] * 3, *[_NUMBER] * 2, *[_ARRAY] * 11]),
    "orthogonal_by_rotations": (None, [*[_SIZE] * 2, _ARRAY]),
    **{
        name: (None, [_SIZE, *[_ARRAY] * 2])
        for name in ("quaternions", "exp", "log", "rotations", "adjoints", "inverses")
    },
    "orthonormalise": (None, [*[_SIZE] * 2, _ARRAY]),
    "shapes": (None, [_SIZE, *[_ARRAY] * 4]),
    "connections": (None, [_ARRAY, _SIZE, *[_ARRAY] * 6]),
    "flow_of_pieces": (_SIZE, [*_RULE, *[_ARRAY] * 5]),
    "work_on_pieces": (_SIZE, [*_RULE, *[_ARRAY] * 3, _SIZE, _ARRAY]),
    "runs": (None, [_ARRAY, _SIZE, *[_ARRAY] * 3]),
    "played": (None, [_ARRAY, _SIZE, _ARRAY, _SIZE, _ARRAY]),
    **{
        name: (None, [_ARRAY, _SIZE, *[_ARRAY] * 3, _SIZE, _ARRAY, _SIZE, *[_ARRAY] * 4])
        for name in ("extrapolated", "extrapolated_twice")
    },
    "extended_size": (_SIZE, []),
    "strung": (None, [_SIZE, *[_ARRAY] * 3]),
    "reach": (None, [_SIZE, _ARRAY, _SIZE, _ARRAY, _NUMBER, _ARRAY]),
    "pieces": (_SIZE, [*[_ARRAY] * 2, _SIZE, *[_ARRAY] * 4, _SIZE, *[_ARRAY] * 2]),
    "repeats": (_SIZE, [*[_SIZE] * 2, _ARRAY, _SIZE, *[_ARRAY] * 3]),
    "screw_chains": (None, [*[_SIZE] * 2, *[_ARRAY] * 4, _SIZE, *[_ARRAY] * 3]),
    "sequence": (_SIZE, [_ARRAY] * 5),
    "pair_prices": (None, [*[_SIZE] * 2, *[_ARRAY] * 5, _SIZE, _NUMBER, _ARRAY]),
    "meetings": (None, [*[_SIZE] * 2, *[_ARRAY] * 5, *[_NUMBER] * 3, *[_ARRAY] * 2]),
    "equations": (_SIZE, [*_RULE, *[_ARRAY] * 3, _SIZE, *[_ARRAY] * 2, _SIZE, *[_ARRAY] * 6]),
    "move_equations": (_SIZE, [*_RULE, *[_ARRAY] * 2, _SIZE, *[_ARRAY] * 2, _SIZE, *[_ARRAY] * 7]),
    "move_bends": (_SIZE, [_SIZE, *[_ARRAY] * 3, _NUMBER, *[_ARRAY] * 2]),
    "bend_rooms": (_SIZE, [_SIZE, *[_ARRAY] * 5, _NUMBER, *[_ARRAY] * 4]),
    "room_slopes": (None, [_SIZE, *[_ARRAY] * 2, _SIZE, *[_ARRAY] * 4]),
    "step_room": (_SIZE, [_SIZE] * 2),
    "bounded_step": (None, [*[_SIZE] * 3, *[_ARRAY] * 4, _NUMBER, _SIZE, *[_ARRAY] * 2]),
    "descent_room": (_SIZE, [*[_SIZE] * 6, _ARRAY]),
    "step_taken": (_SIZE, [*[_NUMBER] * 3, _ARRAY]),
    "descend": (_SIZE, [*_MOTION, _ARRAY, *[_NUMBER] * 4, *[_SIZE] * 2, *[_ARRAY] * 3]),
    "approach": (_SIZE, [*_MOTION, *[_NUMBER] * 2, *[_SIZE] * 3, _NUMBER, _SIZE, _NUMBER, *[_ARRAY] * 5]),
    "steer": (None, [_SIZE, *[_NUMBER] * 2, _SIZE, *[_ARRAY] * 5]),
    "settle": (None, [*[_SIZE] * 3, _ARRAY, _SIZE, *[_ARRAY] * 2, _NUMBER, _SIZE, *[_ARRAY] * 17]),
    "flow_and_derivatives": (_SIZE, [*_RULE, *[_ARRAY] * 3, _SIZE, *[_ARRAY] * 4]),
}
"""What each function returns and takes."""


def load(file: Path) -> ctypes.CDLL:
    """Return a library, with the types of its functions declared.

    Raises:
        ImportError: It is missing, cannot be loaded, or was built from other sources than stand beside it.
    """
    again = "install the package again: python -m pip install . (or -e .), which builds it"
    if not file.is_file():
        raise ImportError(f"the compiled kernel {file} is missing; {again}")
    try:
        library = ctypes.CDLL(str(file))
        library.purcell_digest.restype = ctypes.c_char_p
    except (OSError, AttributeError) as error:
        raise ImportError(f"the compiled kernel {file} cannot be loaded ({error}); {again}") from error
    texts = sources(file.parent)
    if texts and library.purcell_digest().decode() != digest(texts):
        raise ImportError(f"the compiled kernel {file} was built from other sources; {again}")
    for name, (returned, taken) in _SIGNATURES.items():
        function = getattr(library, f"purcell_{name}")
        function.restype, function.argtypes = returned, taken
    return library


KERNEL = load(FILE)
"""The library in use."""
DIGEST: str = KERNEL.purcell_digest().decode()
"""What stands for the text of the sources that it was built from."""
