"""What the compiled library is called and which sources it is built from; the build reads this too."""

from __future__ import annotations

import zlib
from pathlib import Path


def file_name(platform: str) -> str:
    """Return the library's name on a platform: `sys.platform`, or the platform of a wheel's tag."""
    endings = {"win": "dll", "darwin": "dylib", "macosx": "dylib"}
    ending = next((end for start, end in endings.items() if platform.startswith(start)), "so")
    return f"purcell_kernel.{ending}"


def sources(folder: Path) -> list[Path]:
    """Return the C files of a folder and its headers, in order."""
    return sorted(folder.glob("*.[ch]"))


def digest(paths: list[Path]) -> str:
    """Return what stands for the text of the sources, whatever their line ends."""
    return f"{zlib.crc32(b''.join(path.read_bytes().replace(bytes([13, 10]), bytes([10])) for path in paths)):08x}"
