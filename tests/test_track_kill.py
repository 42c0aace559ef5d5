"""A way that is killed while it is swum: its file is whole, and the same way swum again begins with the same rows."""

from __future__ import annotations

import dataclasses
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import Run, runner

from purcell_cli.feedback import track_mission
from purcell_cli.feedback.track import Tracking
from purcell_cli.files.trajectory_reader import read_csv
from purcell_cli.motion.trajectory_table import Table

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="a process is killed as POSIX does it")


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys, "track")


def same_beginning(found: Table, whole: Table) -> bool:
    """Return whether all rows but the last, in which the joints rest, are those with which another file begins."""
    rows = slice(len(found.time_s) - 1)
    return all(
        np.array_equal(getattr(found, name)[rows], getattr(whole, name)[rows])
        for name in ("time_s", "position_m", "base", "limbs", "rate_rad_s")
    )


@pytest.mark.slow
@pytest.mark.nightly
def test_what_was_written_before_a_kill_can_be_read_and_comes_again(
    command: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("truth.yaml").write_text("drag_ratio: 1.7\n")
    arguments = "along-x", "--truth", "truth.yaml", "--out", "real.csv"
    way = subprocess.Popen([sys.executable, "-m", "purcell_cli", "track", *arguments], stdout=subprocess.DEVNULL)
    until = time.monotonic() + 60.0
    while way.poll() is None and time.monotonic() < until and not Path("real.csv").exists():
        time.sleep(0.002)
    way.kill()
    way.wait()
    assert way.returncode == -signal.SIGKILL
    found = read_csv("real.csv")
    assert not np.any(found.rate_rad_s[-1])
    code, _, _ = command(*arguments)
    whole = read_csv("real.csv")
    assert code == 0
    assert found.time_s[-1] < whole.time_s[-1]
    assert same_beginning(found, whole)
    assert not same_beginning(found, dataclasses.replace(whole, position_m=whole.position_m + 1e-12))


def test_a_way_that_is_broken_off_again_takes_nothing_from_its_file(
    command: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where another way was swum, the foil, its file is that of the last."""
    monkeypatch.chdir(tmp_path)
    Path("truth.yaml").write_text("drag_ratio: 1.7\n")
    Path("other.yaml").write_text("drag_ratio: 1.8\n")
    file = Path("real.csv")
    way = "nearby", "--truth", "truth.yaml", "--out", "real.csv"
    assert command(*way)[0] == 0
    whole = file.read_bytes()
    swum = track_mission.track_mission

    def broken_off(*arguments: Any, told: Callable[[Tracking], None], **options: Any) -> Tracking:
        def once(found: Tracking) -> None:
            told(found)
            raise KeyboardInterrupt

        return swum(*arguments, told=once, **options)

    with monkeypatch.context() as patch:
        patch.setattr(track_mission, "track_mission", broken_off)
        assert command(*way)[0] == 130
        assert file.read_bytes() == whole
        assert command("nearby", "--truth", "other.yaml", "--out", "real.csv")[0] == 130
        short = file.read_bytes()
        assert len(short) < len(whole)
    assert command(*way)[0] == 0
    assert file.read_bytes() == whole
    assert command(*way, "--replans", "0")[0] == 1  # a way that ends sooner
    assert len(file.read_bytes()) < len(whole)
