"""Builds the compiled kernel into the wheel: by the machine's compiler, or by one that comes as a package.

`PURCELL_WHEEL=manylinux_2_17_aarch64` (any key of `TARGETS`) builds the wheel of another platform, by ziglang.
"""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

KERNEL = Path("purcell_cli", "kernel")
FLAGS = [
    *("-std=c11", "-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"),  # no sum may be fused
    *("-shared", "-fvisibility=hidden", "-Wno-psabi"),
]
ZIG_FLAGS = ["-mcpu=baseline", "-fno-sanitize=undefined", "-s"]
TARGETS = {
    "manylinux_2_17_x86_64": "x86_64-linux-gnu.2.17",
    "manylinux_2_17_aarch64": "aarch64-linux-gnu.2.17",
    "musllinux_1_2_x86_64": "x86_64-linux-musl",
    "musllinux_1_2_aarch64": "aarch64-linux-musl",
    "macosx_11_0_arm64": "aarch64-macos.11.0",
    "macosx_10_15_x86_64": "x86_64-macos.10.15",
    "win_amd64": "x86_64-windows-gnu",
    "win_arm64": "aarch64-windows-gnu",
}
"""Wheel tags and the targets that ziglang builds for them."""
TRIAL = "#include <math.h>\n#include <stdint.h>\ndouble trial(double x) { return sqrt(x); }\n"


def machine_compiler(scratch: Path) -> list[str] | None:
    """Return the command of the first compiler that can build a library here, or None."""
    text, out = scratch / "trial.c", scratch / "trial.out"
    text.write_text(TRIAL, encoding="ascii")
    for command in [shlex.split(os.environ.get("CC", "")), ["cc"], ["gcc"], ["clang"]]:
        if command and shutil.which(command[0]):
            trial = [*command, *_for_platform(), *FLAGS, str(text), "-o", str(out), "-lm"]
            done = subprocess.run(trial, capture_output=True, check=False)  # noqa: S603 - the user's compiler
            if done.returncode == 0:
                return command
    return None


def _for_platform() -> list[str]:
    return [] if sys.platform == "win32" else ["-fPIC"]


def build(compiler: list[str], sources: list[Path], digest: str, out: Path) -> None:
    """Build the library.

    Raises:
        RuntimeError: The compiler failed, with what it said.
    """
    texts = [str(path) for path in sources if path.suffix == ".c"]
    command = [*compiler, *FLAGS, f'-DPURCELL_DIGEST="{digest}"', *texts, "-o", str(out), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 - the same
    if done.returncode:
        raise RuntimeError(f"the kernel could not be built: {shlex.join(command)}\n{done.stderr}")


class KernelBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the library to the wheel, or puts it into the source tree for an editable installation."""

    def dependencies(self) -> list[str]:
        """Ask for a compiler where the machine has none."""
        with tempfile.TemporaryDirectory() as scratch:
            needed = "PURCELL_WHEEL" in os.environ or machine_compiler(Path(scratch)) is None
        return ["ziglang>=0.13"] if needed else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the library and name the wheel's platform."""
        library = _library_module(Path(self.root, KERNEL))
        platform = os.environ.get("PURCELL_WHEEL") or self._platform()
        name = library.file_name(platform)
        self._scratch = tempfile.TemporaryDirectory()
        scratch = Path(self._scratch.name)
        made = scratch / name
        sources = library.sources(Path(self.root, KERNEL))
        build(self._compiler(scratch), sources, library.digest(sources), made)
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform}"
        if version == "editable":
            place = Path(self.root, KERNEL, name)
            shutil.copyfile(made, place.with_suffix(".new"))
            place.with_suffix(".new").replace(place)  # a process that uses the old one keeps it
        else:
            build_data["force_include"][str(made)] = (KERNEL / name).as_posix()

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002
        """Remove what was built with."""
        self._scratch.cleanup()

    @staticmethod
    def _platform() -> str:
        from packaging.tags import platform_tags

        return next(tag for tag in platform_tags() if "manylinux" not in tag and "musllinux" not in tag)

    @staticmethod
    def _compiler(scratch: Path) -> list[str]:
        wheel = os.environ.get("PURCELL_WHEEL")
        if wheel is not None and wheel not in TARGETS:
            raise ValueError(f"PURCELL_WHEEL: one of {', '.join(TARGETS)} is wanted, found {wheel!r}")
        found = None if wheel else machine_compiler(scratch)
        if found is not None:
            return [*found, *_for_platform()]
        if importlib.util.find_spec("ziglang") is None:
            raise RuntimeError("a C compiler is wanted, found none: install one, or the package ziglang")
        for cache in ("ZIG_LOCAL_CACHE_DIR", "ZIG_GLOBAL_CACHE_DIR"):
            os.environ[cache] = str(scratch / "zig")
        target = ["-target", TARGETS[wheel]] if wheel else []
        return [sys.executable, "-m", "ziglang", "cc", *target, *ZIG_FLAGS]


def _library_module(kernel: Path) -> ModuleType:
    """Return what the package says of the library's name and sources."""
    spec = importlib.util.spec_from_file_location("purcell_kernel_sources", kernel / "sources.py")
    if spec is None or spec.loader is None:
        raise RuntimeError(f"{kernel / 'sources.py'} is missing")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
