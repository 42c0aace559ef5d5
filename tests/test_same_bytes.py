"""The same query is the same file on every processor: settings that choose other arithmetic change no byte."""

from __future__ import annotations

import functools
import json
import os
import platform
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest

PROGRAM = Path(__file__).with_name("plan_digests.py")
KERNELS = {"Prescott": "sse3", "Haswell": "avx2", "Zen": "avx2", "SkylakeX": "avx512f"}
"""Kernels of OpenBLAS, and the instructions without which a processor cannot run them."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
OTHERS = {
    "no vector units": {"NPY_DISABLE_CPU_FEATURES": "X86_V4 X86_V3 AVX512_SKX AVX512F AVX2 FMA3"},
    "no fused sums in the C library": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4"},
    "two threads": {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"},
}
"""What else chooses other arithmetic."""
PAIRS = [("Prescott", "no vector units"), ("Haswell", "two threads"), ("Zen", "no fused sums in the C library")]
"""Settings of different libraries that are tried at once: a plan that one of them changed would differ all the same."""
EVERY = [(name,) for name in (*KERNELS, *OTHERS)]


def digests(names: Iterable[str], effort: str) -> dict[str, str]:
    """Return a digest of each query's trajectory file, planned in a process under settings."""
    setting = dict(ONE_THREAD)
    for name in names:
        setting |= OTHERS.get(name, {"OPENBLAS_CORETYPE": name})
    done = subprocess.run(  # warnings about features that are not there to be disabled go to stderr
        [sys.executable, str(PROGRAM), effort],
        env={**os.environ, **setting},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@functools.cache
def plain(effort: str) -> dict[str, str]:
    """Return the digests under no setting; planned once in a process."""
    return digests((), effort)


def runnable(name: str) -> bool:
    """Return whether this machine can run a setting."""
    flags = Path("/proc/cpuinfo")
    if name not in KERNELS:
        return True
    return platform.machine() == "x86_64" and flags.is_file() and KERNELS[name] in flags.read_text(encoding="ascii")


def same(names: Iterable[str], effort: str) -> None:
    """Assert that settings change no query's file; skip what this processor cannot run."""
    for name in names:
        if not runnable(name):
            pytest.skip(f"this processor cannot run the kernels {name}")
    wanted, found = plain(effort), digests(names, effort)
    assert len(wanted) > 35
    assert len(set(wanted.values())) == len(wanted), "different queries have different files"
    assert {query for query in wanted if wanted[query] != found[query]} == set()


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the setting names units of x86-64")
def test_the_setting_without_vector_units_is_one() -> None:
    """numpy passes over names that it does not know, and they change with its versions."""
    program = (
        "from numpy._core._multiarray_umath import __cpu_features__ as found; "
        "print(int(found['X86_V3'] if 'X86_V3' in found else found['AVX2']))"
    )
    setting = {**os.environ, **ONE_THREAD, **OTHERS["no vector units"]}
    done = subprocess.run([sys.executable, "-c", program], env=setting, capture_output=True, text=True, check=True)
    assert done.stdout == "0\n"


@pytest.mark.slow
@pytest.mark.parametrize("names", [*PAIRS, ("SkylakeX",)], ids=", ".join)
def test_a_plan_is_the_same_file_whatever_the_processor_does(names: tuple[str, ...]) -> None:
    """What takes long is planned with little effort here, and with the usual one under each setting every night."""
    same(names, "mixed")


@pytest.mark.slow
@pytest.mark.nightly
@pytest.mark.parametrize("names", EVERY, ids=", ".join)
def test_a_plan_of_usual_effort_is_the_same_file_under_each_setting_alone(names: tuple[str, ...]) -> None:
    same(names, "standard")
