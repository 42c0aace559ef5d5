"""Batches on a Dask cluster that the test starts: the same bytes, and a worker that is killed loses nothing."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from batches import process, results, roll, still, written

pytest.importorskip("distributed")
pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="a worker is killed as POSIX does it")

SCENARIOS = [still("first", 1), *(roll(f"r{k}", k + 1) for k in range(10)), "name: bad\nstart: 1\ngoal: {}"]


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Start a scheduler and two workers on this machine; return its address and the workers."""
    file = tmp_path / "scheduler.json"
    where = ["--scheduler-file", str(file)]
    quiet: dict[str, Any] = {
        "stdout": subprocess.DEVNULL,
        "stderr": subprocess.DEVNULL,
        "env": os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    }
    dask = [sys.executable, "-m", "dask"]
    scheduler = subprocess.Popen(
        [*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", *where], **quiet
    )
    worker = [*dask, "worker", "--nthreads", "1", "--no-nanny", "--no-dashboard", *where]
    worker += ["--local-directory", str(tmp_path / "spill")]
    workers = [subprocess.Popen(worker, **quiet) for _ in range(2)]
    try:
        until = time.monotonic() + 60.0
        while not file.exists() or not file.read_text().endswith("}"):
            assert time.monotonic() < until
            time.sleep(0.05)
        yield json.loads(file.read_text())["address"], workers
    finally:
        for each in (*workers, scheduler):
            each.kill()
            each.wait()


@pytest.mark.slow
def test_a_cluster_gives_the_same_bytes_even_when_a_worker_is_killed_half_way(
    tmp_path: Path, cluster: tuple[str, list[subprocess.Popen[bytes]]]
) -> None:
    address, workers = cluster
    scenarios = written(tmp_path / "s", SCENARIOS)
    there = process(str(scenarios), "--out", "there", "--dask", address, cwd=tmp_path)
    here = process(str(scenarios), "--out", "here", "--jobs", "1", cwd=tmp_path)
    while not (tmp_path / "there" / "r2.json").exists():
        assert there.poll() is None, there.communicate()
        time.sleep(0.005)
    workers[0].send_signal(signal.SIGKILL)
    assert not (tmp_path / "there" / "r9.json").exists(), "there was work left to do"
    for batch in (there, here):
        _, err = batch.communicate()
        assert batch.returncode == 1, err
        assert "bad: verdict: wanted reached, found error" in err
        assert "12 of 12" in err
    assert results(tmp_path / "there") == results(tmp_path / "here")


@pytest.mark.slow
def test_an_address_where_nothing_answers_is_a_clear_message(tmp_path: Path) -> None:
    scenarios = written(tmp_path / "s", [still("a", 1)])
    batch = process(str(scenarios), "--dask", "tcp://127.0.0.1:9", cwd=tmp_path)
    out, err = batch.communicate()
    assert (batch.returncode, out) == (2, ""), err
    assert "--dask: wanted a Dask scheduler at tcp://127.0.0.1:9" in err
    assert "Traceback" not in err
