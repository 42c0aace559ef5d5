"""Builds the source distribution, and a wheel for every platform by ziglang, into a folder.

python -m pip install build hatchling ziglang
python tools/build_wheels.py dist
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))


def main(folder: str) -> None:
    """Build all of them."""
    from hatch_build import TARGETS

    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, str(ROOT)]
    subprocess.run([*command, "--sdist"], check=True)  # noqa: S603 - the build tool
    for wheel in TARGETS:
        subprocess.run([*command, "--wheel"], env={**os.environ, "PURCELL_WHEEL": wheel}, check=True)  # noqa: S603 - the same
        print(wheel)


if __name__ == "__main__":
    main(*sys.argv[1:])
