"""Distinct numbers and rows: those of numpy, without its masked arrays."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from purcell_cli.geometry.distinct import distinct

RNG = np.random.default_rng(3)
CASES = {
    "none": np.empty(0),
    "one": np.array([3.5]),
    "numbers": np.round(RNG.normal(size=200), 1),
    "whole numbers": RNG.integers(-4, 4, 300),
    "words of 64 bits": RNG.integers(0, 5, 50, dtype=np.uint64) << np.uint64(61),
    "rows": RNG.integers(0, 3, (200, 3)),
    "zeros of either sign": np.array([[0.0, 1.0], [-0.0, 1.0], [-1.0, 2.0], [0.0, -1.0]]),
}


@pytest.mark.parametrize("name", CASES)
def test_they_are_those_of_numpy(name: str) -> None:
    values = CASES[name]
    _, first, which = np.unique(values, axis=0, return_index=True, return_inverse=True)
    found, mine = distinct(values)
    assert found.tolist() == first.tolist()
    assert mine.tolist() == which.ravel().tolist()


def test_a_plan_needs_no_masked_arrays() -> None:
    program = (
        "import sys\n"
        "import numpy as np\n"
        "from purcell_cli import Configuration, plan\n"
        "from purcell_cli.geometry import se3\n"
        "away = se3.pose(np.eye(3), [0.0, 0.0, 0.004])\n"
        "shape = np.broadcast_to(np.eye(3), (2, 3, 3))\n"
        "assert plan(Configuration(np.eye(4), shape), Configuration(away, shape)).verdict == 'reached'\n"
        "print('numpy.ma' in sys.modules)\n"
    )
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout == "False\n", "a call of numpy's that imports masked arrays is on the way of a plan"
