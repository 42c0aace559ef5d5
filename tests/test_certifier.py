"""The certificate by a process of its own: the same verdict, here where that process fails, and none left behind."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from purcell_cli import Configuration, PlanOptions, plan
from purcell_cli.motion.trajectory import schedule
from purcell_cli.verification import certifier_process
from purcell_cli.verification.certificate import Certificate, certify

GOAL = Configuration.from_angles((0.01, 0.0, 0.0), (20.0, 0.0, 0.0))

_COMMAND = """
import sys
from purcell_cli.cli.app import main
sys.argv = ["purcell", "plan", "nearby", "--out", sys.argv[1]]
try:
    main()
except SystemExit as end:
    print("code", end.code)
print("scipy.integrate" in sys.modules)
"""


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[bytes]]:
    """Have certifiers started though this process has imported everything, and collect them."""
    processes: list[subprocess.Popen[bytes]] = []
    begin = certifier_process._started

    def begun() -> subprocess.Popen[bytes] | None:
        process = begin()
        assert process is not None
        processes.append(process)
        return process

    monkeypatch.delitem(sys.modules, "scipy.integrate", raising=False)
    monkeypatch.setattr(certifier_process, "_started", begun)
    return processes


def _asked(certifying: Callable[..., Certificate], *, off_m: float = 0.0) -> Certificate:
    solution = plan(Configuration(), GOAL, options=PlanOptions(effort="quick"), certify=certify)
    pose = GOAL.pose.copy()
    pose[0, 3] += off_m
    motion: tuple[Any, ...] = (solution.plan.swimmer, Configuration(), Configuration(pose, GOAL.shape))
    return certifying(*motion, *schedule(solution.plan.swimmer, solution.plan.blocks))


@pytest.mark.slow
def test_it_finds_what_is_found_here(started: list[subprocess.Popen[bytes]]) -> None:
    with certifier_process.certifier() as certifying:
        there = _asked(certifying)
    assert there == _asked(certify)
    assert there.reached
    assert [p.poll() is None for p in started] == [False]


@pytest.mark.slow
def test_a_motion_that_misses_is_not_certified_there_either(started: list[subprocess.Popen[bytes]]) -> None:
    with certifier_process.certifier() as certifying:
        there = _asked(certifying, off_m=1e-6)
    assert not there.reached
    assert np.isclose(there.deviation.position_m, 1e-6, rtol=1e-3)
    assert len(started) == 1


def test_where_it_fails_the_certificate_is_made_here(
    started: list[subprocess.Popen[bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(certifier_process, "_SERVE", "raise SystemExit(1)")
    with certifier_process.certifier() as certifying:
        assert _asked(certifying) == _asked(certify)
    assert started[0].returncode == 1


def test_it_ends_with_the_command_that_does_not_ask_it(started: list[subprocess.Popen[bytes]]) -> None:
    with pytest.raises(KeyboardInterrupt), certifier_process.certifier():
        raise KeyboardInterrupt
    assert started[0].returncode is not None


@pytest.mark.slow
def test_a_command_imports_no_integrators_and_has_its_plan_certified(tmp_path: Any) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _COMMAND, str(tmp_path / "a.csv")], capture_output=True, encoding="utf-8", check=True
    )
    assert "\nreached\n" in done.stdout
    assert done.stdout.endswith("False\n")
