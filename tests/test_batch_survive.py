"""Nothing is lost: batches that are killed go on, and a worker, a disk or a folder that fails costs no other result."""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from batches import process, results, roll, rows, still, written
from helpers import NIGHTLY

from purcell_cli.batch.cases import find_cases
from purcell_cli.batch.local_workers import _interrupts_held
from purcell_cli.batch.results_folder import JOURNAL, ResultsFolder, write_files
from purcell_cli.batch.runner import Options, Outcome, run_batch
from purcell_cli.batch.solve_one import Settings
from purcell_cli.errors import ResultsError
from purcell_cli.motion.options import PlanOptions

resource = pytest.importorskip("resource", reason="kills and limits are those of POSIX")

SETTINGS = Settings(PlanOptions(effort="quick"))

MANY = [roll(f"r{k}", k + 1) if k % 3 else still(f"s{k}", k + 1) for k in range(80)]
"""Eight for each kill, of which a quick machine may finish several before it."""


def finished(folder: Path) -> list[str]:
    """Return which scenarios the journal vouches for."""
    journal = folder / JOURNAL
    text = journal.read_bytes() if journal.exists() else b""
    return [json.loads(line)["name"] for line in text.splitlines(keepends=True) if line.endswith(b"\n")]


def stamps(folder: Path, names: list[str]) -> dict[str, int]:
    """Return when the files of scenarios were written."""
    return {name: (folder / f"{name}.json").stat().st_mtime_ns for name in names}


def kill_at_random(scenarios: Path, out: Path, seed: int, kills: int, told: list[str]) -> None:
    """Kill a batch and start it again, over and over; note what was finished and done again all the same."""
    rng = random.Random(seed)
    for k in range(kills):
        known = finished(out)
        before = stamps(out, known)
        batch = process(str(scenarios), "--out", str(out), "--jobs", "1", "--resume", cwd=out.parent)
        # Half of the kills come as the work goes on, the others at any moment from the start of the process.
        until = time.monotonic() + (60.0 if k % 2 else rng.uniform(0.0, 1.5))
        more = len(known) + rng.randrange(1, 3)
        while batch.poll() is None and time.monotonic() < until and len(finished(out)) < more:
            time.sleep(0.002)
        time.sleep(rng.uniform(0.0, 0.15))
        if rng.random() < 0.5:
            batch.kill()
        else:
            os.killpg(batch.pid, signal.SIGKILL)
        batch.communicate()
        if batch.returncode == -signal.SIGKILL:
            told.append("killed")
        if stamps(out, known) != before:
            told.append(f"done again: {known}")


@pytest.mark.slow
@pytest.mark.parametrize("kills", [4, pytest.param(10, marks=NIGHTLY)])
def test_batches_killed_at_random_moments_end_with_the_same_bytes(tmp_path: Path, kills: int) -> None:
    """Two batches, each as often."""
    many = MANY[: 8 * kills]
    scenarios = written(tmp_path / "s", many)
    told: list[str] = []
    outs = [tmp_path / "one", tmp_path / "two"]
    for out in outs:
        out.mkdir()
    chains = [
        threading.Thread(target=kill_at_random, args=(scenarios, out, seed, kills, told))
        for seed, out in enumerate(outs)
    ]
    for chain in chains:
        chain.start()
    for chain in chains:
        chain.join()
    assert told == ["killed"] * (2 * kills)
    assert any(0 < len(finished(out)) < len(many) for out in outs), "some were killed half way"
    paths = [*outs, tmp_path / "undisturbed"]
    runs = [process(str(scenarios), "--out", str(out), "--jobs", "1", "--resume", cwd=tmp_path) for out in paths]
    assert [run.communicate() and run.returncode for run in runs] == [0, 0, 0]
    one, two, undisturbed = (results(path) for path in paths)
    assert len(undisturbed) == 2 * len(many) + 4
    assert one == undisturbed
    assert two == undisturbed


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_its_scenario_alone_and_resume_makes_up_for_it(tmp_path: Path) -> None:
    slow = "name: slow\nstart: {}\ngoal: {base: {position_m: [12, 4, 0]}}\n"  # more than fifty thousand rows
    cases = find_cases([str(written(tmp_path / "s", [slow, *(still(f"s{k}", k + 1) for k in range(4))]))])
    told: list[str] = []

    def kill_all(outcome: Outcome, row: dict[str, Any]) -> None:
        told.append(row["name"])
        if outcome.scenarios == 1:
            for worker in multiprocessing.active_children():
                worker.kill()
                worker.join()

    options = Options(tmp_path / "out", jobs=2)
    outcome = run_batch(cases, SETTINGS, options, kill_all)
    found = rows(options.folder)
    assert told[0] == "s0", "the slow one was still at work"
    assert (outcome.scenarios, outcome.failed, outcome.crashed, outcome.verdict) == (5, 1, 1, "failed")
    assert found["slow"]["verdict"] == "crashed"
    assert "its worker process died, killed by SIGKILL" in found["slow"]["reasons"][0]
    assert all(found[f"s{k}"]["passed"] for k in range(4))
    again = run_batch(cases, SETTINGS, Options(tmp_path / "out", resume=True))
    assert (again.solved, again.failed) == (1, 0)
    run_batch(cases, SETTINGS, Options(tmp_path / "undisturbed"))
    assert results(tmp_path / "out") == results(tmp_path / "undisturbed")


@pytest.mark.slow
def test_a_full_disk_ends_the_batch_with_a_clear_message_and_what_is_finished_is_kept(tmp_path: Path) -> None:
    scenarios = written(tmp_path / "s", [*(still(f"s{k}", k + 1) for k in range(3)), roll("large", 9)])

    def small_files() -> None:  # a file that may not grow fails like one on a full disk
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (2500, 2500))

    batch = process(str(scenarios), "--jobs", "1", "--json", cwd=tmp_path, preexec_fn=small_files)
    out, err = batch.communicate()
    assert batch.returncode == 1, err
    assert json.loads(out)["verdict"] == "error"
    assert "large.csv: cannot be written" in err
    assert "3 of 4 scenarios are finished and kept; --resume goes on from there" in err
    assert "Traceback" not in err
    folder = tmp_path / "purcell-results"
    assert finished(folder) == ["s0", "s1", "s2"]
    assert not list(folder.glob(".*.part"))
    cases = find_cases([str(scenarios)])
    assert run_batch(cases, SETTINGS, Options(folder, resume=True)).solved == 1


@pytest.mark.slow
def test_a_folder_that_cannot_be_made_is_a_clear_message(tmp_path: Path) -> None:
    scenarios = written(tmp_path / "s", [still("a", 1)])
    (tmp_path / "file").write_text("")
    batch = process(str(scenarios), "--out", "file/out", cwd=tmp_path)
    out, err = batch.communicate()
    assert (batch.returncode, out) == (1, "")
    assert err == "purcell batch: file/out: cannot be written (Not a directory)\n"


def assert_gone(group: int) -> None:
    """Assert that the processes of a session end soon."""
    until = time.monotonic() + 20.0
    with contextlib.suppress(ProcessLookupError):
        while time.monotonic() < until:
            os.killpg(group, 0)
            time.sleep(0.05)
        pytest.fail("processes of the batch are still there")


def under_way(folder: Path) -> subprocess.Popen[str]:
    """Return a batch of 41 scenarios that has finished one."""
    scenarios = written(folder / "s", [still("a", 1), *(roll(f"r{k}", k + 1) for k in range(40))])
    batch = process(str(scenarios), "--jobs", "2", cwd=folder)
    while not finished(folder / "purcell-results"):
        assert batch.poll() is None
        time.sleep(0.01)
    return batch


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals cannot be held back here")
def test_what_starts_while_interrupts_are_held_never_hears_of_one() -> None:
    """Started at any other time (the foil) it does, and so does this process afterwards."""
    asks = [sys.executable, "-c", "import signal; print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))"]
    with _interrupts_held():
        held = subprocess.run(asks, capture_output=True, text=True, check=True).stdout
    assert (held, subprocess.run(asks, capture_output=True, text=True, check=True).stdout) == ("True\n", "False\n")
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


FIRST_WORKER = """
import multiprocessing, signal
from purcell_cli.batch.local_workers import _interrupts_held

def asked():
    print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))

if __name__ == "__main__":
    worker = multiprocessing.get_context("spawn").Process(target=asked)
    with _interrupts_held():
        worker.start()
    worker.join()
"""


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals cannot be held back here")
def test_the_first_worker_of_a_process_hears_of_no_interrupt_either(tmp_path: Path) -> None:
    """Beside it multiprocessing starts a process of its own, and unblocks what it blocked for that."""
    script = tmp_path / "first.py"
    script.write_text(FIRST_WORKER)
    said = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=True).stdout
    assert said == "True\n"


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals cannot be held back here")
def test_an_interrupt_that_another_thread_hears_is_held_back_too() -> None:
    done, passed = threading.Event(), list[bool]()
    thread = threading.Thread(target=done.wait)
    thread.start()

    def interrupted() -> None:
        with _interrupts_held():
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.1)
            passed.append(True)

    try:
        with pytest.raises(KeyboardInterrupt):
            interrupted()
    finally:
        done.set()
        thread.join()
    assert passed == [True]


@pytest.mark.slow
def test_an_interrupt_says_how_far_the_batch_came_and_leaves_no_process(tmp_path: Path) -> None:
    batch = under_way(tmp_path)
    os.killpg(batch.pid, signal.SIGINT)
    _, err = batch.communicate()
    assert batch.returncode == 130
    assert "of 41 scenarios are finished and kept; --resume goes on from there" in err
    assert "Traceback" not in err
    assert_gone(batch.pid)


@pytest.mark.slow
def test_workers_end_when_their_batch_is_killed(tmp_path: Path) -> None:
    batch = under_way(tmp_path)
    batch.kill()
    batch.communicate()
    assert_gone(batch.pid)


@pytest.mark.parametrize("cut", [1, 7, 30])
def test_a_journal_with_a_torn_line_or_holes_vouches_only_for_what_is_whole(tmp_path: Path, cut: int) -> None:
    key = "ab" * 32
    with ResultsFolder(tmp_path) as folder:
        for name in ("a", "b"):
            folder.keep(name, key, {"n": name}, write_files(tmp_path, name, {".json": name.encode()}))
    journal = tmp_path / JOURNAL
    data = journal.read_bytes()
    (tmp_path / ".a.csv.0123456789ab.part").write_text("left by a writer that was killed")
    journal.write_bytes(data[:-cut])
    with ResultsFolder(tmp_path, resume=True) as folder:
        assert (folder.row("a"), folder.row("b")) == ({"n": "a"}, None)
        assert not folder.has("a", "cd" * 32)
        folder.keep("c", key, {"n": "c"}, {})
    assert not list(tmp_path.glob("*.part"))
    journal.write_bytes(b"\0" * 100 + b"\n{}\n[]\n" + data)
    (tmp_path / "b.json").write_text("other")
    with ResultsFolder(tmp_path, resume=True) as folder:
        assert (folder.has("a", key), folder.has("b", key)) == (True, False)
    with ResultsFolder(tmp_path) as folder:
        assert folder.row("a") is None, "without resume a batch begins anew"


def test_files_that_cannot_be_written_are_an_error_of_results(tmp_path: Path) -> None:
    (tmp_path / "a.json").mkdir()
    with pytest.raises(ResultsError, match=r"a\.json"):
        write_files(tmp_path, "a", {".json": b"x"})
