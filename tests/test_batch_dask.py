"""Batches on a Dask cluster that the test starts: the same bytes, and a worker that is killed loses nothing."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from batches import process, results, roll, still, written

from purcell_cli import __version__
from purcell_cli.batch import dask_workers
from purcell_cli.batch.solve_one import Settings
from purcell_cli.errors import InputError, ResultsError

pytest.importorskip("distributed")
pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="a worker is killed as POSIX does it")

SCENARIOS = [still("first", 1), *(roll(f"r{k}", k + 1) for k in range(32)), "name: bad\nstart: 1\ngoal: {}"]


def scheduler_alone(file: Path, **options: Any) -> subprocess.Popen[bytes]:
    """Start a scheduler on this machine that writes its address into a file."""
    dask = [sys.executable, "-m", "dask", "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    return subprocess.Popen([*dask, "--scheduler-file", str(file)], **options)


def address_in(file: Path) -> str:
    """Wait for a scheduler to write its address, and return it."""
    until = time.monotonic() + 60.0
    while not file.exists() or not file.read_text().endswith("}"):
        assert time.monotonic() < until
        time.sleep(0.05)
    return str(json.loads(file.read_text())["address"])


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
    scheduler = scheduler_alone(file, **quiet)
    worker = [*dask, "worker", "--nthreads", "1", "--no-nanny", "--no-dashboard", *where]
    worker += ["--local-directory", str(tmp_path / "spill")]
    workers = [subprocess.Popen(worker, **quiet) for _ in range(2)]
    try:
        yield address_in(file), workers
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
    while not (tmp_path / "there" / "r0.json").exists():
        assert there.poll() is None, there.communicate()
        time.sleep(0.005)
    workers[0].send_signal(signal.SIGKILL)
    assert not (tmp_path / "there" / "r31.json").exists(), "there was work left to do"
    for batch in (there, here):
        _, err = batch.communicate()
        assert batch.returncode == 1, err
        assert "bad: verdict: wanted reached, found error" in err
        assert "34 of 34" in err
    assert results(tmp_path / "there") == results(tmp_path / "here")


@pytest.mark.slow
def test_an_address_where_nothing_answers_is_a_clear_message(tmp_path: Path) -> None:
    scenarios = written(tmp_path / "s", [still("a", 1)])
    batch = process(str(scenarios), "--dask", "tcp://127.0.0.1:9", cwd=tmp_path)
    out, err = batch.communicate()
    assert (batch.returncode, out) == (2, ""), err
    assert "--dask: wanted a Dask scheduler at tcp://127.0.0.1:9" in err
    assert "Traceback" not in err


@pytest.fixture
def lonely(tmp_path: Path) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """Start a scheduler without workers, and return its address and its process."""
    file, quiet = tmp_path / "scheduler.json", subprocess.DEVNULL
    scheduler = scheduler_alone(file, stdout=quiet, stderr=quiet)
    try:
        yield address_in(file), scheduler
    finally:
        scheduler.kill()
        scheduler.wait()


class Lines(list[str]):
    """Collects what is said, and ends a process after some lines."""

    def __init__(self, process: subprocess.Popen[bytes], most: int) -> None:
        self.process, self.most = process, most

    def __call__(self, line: str) -> None:
        self.append(line)
        if len(self) == self.most:
            self.process.kill()


@pytest.mark.slow
def test_without_a_worker_it_is_said_how_many_there_are_and_a_lost_scheduler_ends_the_wait(
    tmp_path: Path, lonely: tuple[str, subprocess.Popen[bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    address, scheduler = lonely
    monkeypatch.setattr(dask_workers, "_SECONDS_OF_SILENCE", 0.5)
    said = Lines(scheduler, 3)
    with pytest.raises(ResultsError, match=f"^the Dask scheduler at {address} is lost") as caught:
        list(dask_workers.solve_there(iter(()), Settings(), tmp_path, address, said))
    assert said == [f"0 workers at the Dask scheduler {address}"] * 3
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "found"),
    [
        (
            "__import__('no_such_package').__version__",
            "one that cannot import it (ModuleNotFoundError: No module named ",
        ),
        ("'0.0.1'", "0.0.1"),
    ],
)
def test_a_cluster_without_this_version_of_the_package_is_refused(
    tmp_path: Path,
    lonely: tuple[str, subprocess.Popen[bytes]],
    monkeypatch: pytest.MonkeyPatch,
    asked: str,
    found: str,
) -> None:
    monkeypatch.setattr(dask_workers, "_ASKED", asked)
    with pytest.raises(InputError) as caught:
        list(dask_workers.solve_there(iter(()), Settings(), tmp_path, lonely[0], print))
    assert f"--dask: wanted a scheduler with version {__version__} of purcell-cli, found {found}" in str(caught.value)


@pytest.mark.slow
def test_what_speaks_otherwise_than_a_scheduler_is_a_clear_message(tmp_path: Path) -> None:
    """As a scheduler of another version of Dask does: its answers end in errors of any kind."""
    scenarios = written(tmp_path / "s", [still("a", 1)])
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=answering, args=(server,), daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        batch = process(str(scenarios), "--dask", address, cwd=tmp_path)
        out, err = batch.communicate()
    assert (batch.returncode, out) == (2, ""), err
    assert f"--dask: wanted a Dask scheduler at {address}, found none (" in err
    assert "Traceback" not in err


def answering(server: socket.socket) -> None:
    """Answer every connection with what is no message of Dask's."""
    with contextlib.suppress(OSError):
        while True:
            connection, _ = server.accept()
            connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" + 100 * b"x")
            connection.close()
