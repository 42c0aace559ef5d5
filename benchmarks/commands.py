"""Processor time of whole commands, each in a process of its own as a user starts it.

    python -m benchmarks.commands --runs 3 --write

A command's time is the median of its runs, all of its processes counted, after one that is not counted. `--write` puts
the table into docs/explanation/cannot.md. It wants the extra `plot`.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile

from benchmarks import pages

COMMANDS = (
    "--help",
    "controllability",
    "gait --all",
    "gait x-motion",
    "plan far",
    "plan nearby",
    "view trajectory.csv",
    "verify trajectory.csv nearby",
    "controllability --map",
    "plot x-motion",
    "plan along-z --controls simultaneous",
    "plan nearby --effort thorough",
    "figures",
    "design",
)
"""What is timed, in this order in one folder: the plan of `nearby` is what `view` and `verify` read."""


def spent() -> float:
    """Return the processor's time of all processes that this one has started and that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def timed(command: str, runs: int, folder: str) -> float:
    """Return the median time of a command [s].

    Raises:
        subprocess.CalledProcessError: the command failed.
    """
    surroundings = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    times = []
    for _ in range(runs + 1):
        began = spent()
        subprocess.run(  # noqa: S603  # this very program
            [sys.executable, "-m", "purcell_cli", *command.split()],
            cwd=folder,
            env=surroundings,
            capture_output=True,
            check=True,
        )
        times.append(spent() - began)
    return statistics.median(times[1:])


def main() -> None:
    """Measure, print and perhaps write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=3, help="runs of each command that are counted")
    parser.add_argument("--write", action="store_true", help="put the table into docs/explanation/cannot.md")
    asked = parser.parse_args()
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for command in COMMANDS:
            found[command] = timed(command, asked.runs, folder)
            print(f"{found[command]:6.2f} s  purcell {command}", flush=True)
    rows = [
        f"| `purcell {command}` | {seconds:.2f} |" for command, seconds in sorted(found.items(), key=lambda p: p[1])
    ]
    text = "\n".join(["| command | time [s] |", "| --- | --- |", *rows])
    if asked.write:
        pages.put("explanation/cannot.md", "times", text)


if __name__ == "__main__":
    main()
