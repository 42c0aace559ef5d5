"""Commands that are stopped while they write: by a signal, a full disk, or a reader that is gone.

Whatever happens, what a command was to write is there as it was before or as a whole new file, no temporary file is
left (but by a kill, after which nothing can be tidied up), and no process of it lives on.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from purcell_cli import Swimmer, plan, read_csv, write_csv
from purcell_cli.files.builtin import find_scenario
from purcell_cli.files.plan_file import PlanDocument, write_plan
from purcell_cli.motion.options import PlanOptions

PURCELL = (sys.executable, "-P", "-m", "purcell_cli")

COMMANDS = {
    "plan": ("plan along-x --effort quick --dt 2e-4 --plan-out plan.json --out out.csv", ("out.csv", "plan.json")),
    "gait": ("gait x-motion --cycles 200 --out out.csv", ("out.csv",)),
    "simulate": ("simulate rows.csv --swimmer truth.yaml --out out.csv", ("out.csv",)),
    "track": ("track along-x --truth truth.yaml --out out.csv", ("out.csv",)),
    "replan": ("replan --from measured.yaml whole.json --out out.csv", ("out.csv",)),
    "fit": ("fit rows.csv --out out.yaml", ("out.yaml",)),
    "export": ("export rows.csv --to servo --map map.yaml --rate 5000 --out out.csv", ("out.csv",)),
    "view": ("view rows.csv --out out.html", ("out.html",)),
    "plot": ("plot rows.csv --out out.png", ("out.png",)),
    "batch": ("batch along-x yaw roll --effort quick --jobs 2 --junit report.xml --out results", ("report.xml",)),
}
"""Commands that write, and the files that they replace: each is seen whole once, and then stopped."""

HOW = ("SIGINT", "SIGTERM", "SIGKILL", "full disk", "closed pipe")
"""What happens to a command."""

_LONGEST_S = 300.0
"""A command that takes longer than this [s] is said to hang."""
_GONE_S = 15.0
"""How long processes of a command that was killed may live on [s]: a worker of a batch looks for its parent."""
_OLD = "before"
"""What stands in a file that is to be replaced."""


class Interrupted:
    """The commands, each run once as a whole.

    Args:
        folder: An empty folder for what they read and write.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._inputs, self._done = folder / "inputs", dict[str, tuple[float, dict[str, bytes]]]()
        self._inputs.mkdir()
        query = find_scenario("along-x")
        rows = plan(query.start, query.goal, swimmer=Swimmer(), options=PlanOptions(effort="quick", dt_s=1e-3))
        write_csv(rows.trajectory, self._inputs / "rows.csv")
        write_plan(PlanDocument(rows.plan, rows.options), self._inputs / "whole.json")
        (self._inputs / "measured.yaml").write_text("base: {position_m: [0.001, 0, 0]}\n")
        (self._inputs / "truth.yaml").write_text("slenderness: 0.02\n")
        servos = "lock_margin_deg: 4.0\n"
        (self._inputs / "map.yaml").write_text(servos)

    def _here(self, name: str) -> Path:
        """Return a new folder with what a command reads, and an old file for each that it writes."""
        here = self._folder / "here"
        shutil.rmtree(here, ignore_errors=True)
        shutil.copytree(self._inputs, here)
        for file in COMMANDS[name][1]:
            (here / file).write_text(_OLD)
        return here

    def _whole(self, name: str) -> tuple[float, dict[str, bytes]]:
        """Return how long a command takes [s], and what it then has written."""
        if name not in self._done:
            here, begun = self._here(name), time.monotonic()
            subprocess.run(  # noqa: S603  # this very program
                [*PURCELL, *COMMANDS[name][0].split()], cwd=here, check=True, capture_output=True, timeout=_LONGEST_S
            )
            spent = time.monotonic() - begun
            self._done[name] = spent, {file: (here / file).read_bytes() for file in COMMANDS[name][1]}
        return self._done[name]

    def stopped(self, name: str, how: str, rng: np.random.Generator) -> str:
        """Return what a command leaves that is stopped at a random moment."""
        lasts_s, whole = self._whole(name)
        here, about = self._here(name), f"{name}, {how}"
        limit: Callable[[], None] | None = None
        if how == "full disk":
            most = int(rng.uniform(0.0, max(map(len, whole.values()))))

            def limit() -> None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

        reader, writer = os.pipe()
        with subprocess.Popen(  # noqa: S603  # this very program
            [*PURCELL, *COMMANDS[name][0].split()],
            cwd=here,
            stdout=writer,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=limit,  # nothing here runs threads
            env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},  # a full disk would leave modules cut short
        ) as process:
            os.close(writer)
            if how == "closed pipe":
                os.close(reader)
            if how.startswith("SIG"):
                time.sleep(float(rng.uniform(0.0, 1.1 * lasts_s)))
                process.send_signal(signal.Signals[how])
            _, told = process.communicate(timeout=_LONGEST_S)
        if how != "closed pipe":
            os.close(reader)
        faults = [*_left(here, how), *_halves(here, whole, name), *_ended(process, told, how)]
        return f"WRONG: {about}: {'; '.join(faults)}" if faults else f"{about}: nothing lost"


def _left(here: Path, how: str) -> Iterator[str]:
    """Yield the temporary files that a command left, unless it was killed."""
    left = sorted(str(path.relative_to(here)) for path in here.rglob("*.part"))
    if left and how != "SIGKILL":
        yield f"left {', '.join(left)}"


def _halves(here: Path, whole: dict[str, bytes], name: str) -> Iterator[str]:
    """Yield the files that are neither as they were nor as they were to become."""
    for file, wanted in whole.items():
        found = (here / file).read_bytes()
        if found in {_OLD.encode(), wanted} or file == "report.xml":
            continue
        if name == "track":  # what was swum up to a measurement is a whole file too
            read_csv(here / file)
            continue
        yield f"{file} has {len(found)} of {len(wanted)} bytes"
    report = here / "report.xml"
    if report.exists() and report.read_text() != _OLD and "</testsuites>" not in report.read_text():
        yield "half a report"
    for path in here.rglob("*.json"):
        if path.read_text() != _OLD:
            json.loads(path.read_text())
    for path in here.glob("results/*.csv"):
        if path.name != "summary.csv":
            read_csv(path)


def _ended(process: subprocess.Popen[bytes], told: bytes, how: str) -> Iterator[str]:
    """Yield what is wrong with how a command ended, and with what processes live on."""
    if b"Traceback" in told:
        yield f"a traceback: {told.decode(errors='replace').splitlines()[-1]}"
    if how == "closed pipe" and process.returncode:
        yield f"ended with {process.returncode}"
    until = time.monotonic() + _GONE_S
    while _alive(process.pid):
        if time.monotonic() > until:
            os.killpg(process.pid, signal.SIGKILL)  # the command's own group
            yield "a process lived on"
            return
        time.sleep(0.1)


def _alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def interrupted(count: int, seed: int, folder: Path) -> Iterator[str]:
    """Yield what commands leave that are stopped at random moments, each command in each way by turns."""
    commands = Interrupted(folder)
    every = [(name, how) for how in HOW for name in COMMANDS]
    for k in range(seed, seed + count):
        name, how = every[(k * 7) % len(every)]  # 7 has no factor in common with their number: all come by turns
        yield commands.stopped(name, how, np.random.default_rng(k))
