"""The same query is the same file on every processor: settings that choose other arithmetic change no byte."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).with_name("plan_digests.py")
KERNELS = {"Prescott": "sse3", "Haswell": "avx2", "Zen": "avx2", "SkylakeX": "avx512f"}
"""Kernels of OpenBLAS, and the instructions without which a processor cannot run them."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
SETTINGS = {
    **{kernel: {"OPENBLAS_CORETYPE": kernel, **ONE_THREAD} for kernel in KERNELS},
    "no vector units": {"NPY_DISABLE_CPU_FEATURES": "X86_V4 X86_V3 AVX512_SKX AVX512F AVX2 FMA3", **ONE_THREAD},
    "no fused sums in the C library": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4", **ONE_THREAD},
    "two threads": {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"},
}


def digests(setting: dict[str, str]) -> dict[str, str]:
    """Return a digest of each query's trajectory file, planned in a process under a setting."""
    done = subprocess.run(  # warnings about features that are not there to be disabled go to stderr
        [sys.executable, str(PROGRAM)], env={**os.environ, **setting}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def plain() -> dict[str, str]:
    return digests(ONE_THREAD)


def runnable(name: str) -> bool:
    """Return whether this machine can run a setting."""
    flags = Path("/proc/cpuinfo")
    if name not in KERNELS:
        return True
    return platform.machine() == "x86_64" and flags.is_file() and KERNELS[name] in flags.read_text(encoding="ascii")


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the setting names units of x86-64")
def test_the_setting_without_vector_units_is_one() -> None:
    """numpy passes over names that it does not know, and they change with its versions."""
    program = (
        "from numpy._core._multiarray_umath import __cpu_features__ as found; "
        "print(int(found['X86_V3'] if 'X86_V3' in found else found['AVX2']))"
    )
    setting = {**os.environ, **SETTINGS["no vector units"]}
    done = subprocess.run([sys.executable, "-c", program], env=setting, capture_output=True, text=True, check=True)
    assert done.stdout == "0\n"


@pytest.mark.slow
@pytest.mark.parametrize("name", SETTINGS)
def test_a_plan_is_the_same_file_whatever_the_processor_does(name: str, plain: dict[str, str]) -> None:
    if not runnable(name):
        pytest.skip(f"this processor cannot run the kernels {name}")
    found = digests(SETTINGS[name])
    assert len(plain) > 35
    assert len(set(plain.values())) == len(plain), "different queries have different files"
    assert {query for query in plain if plain[query] != found[query]} == set()
