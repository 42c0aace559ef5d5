"""Batches: scenarios a second with one worker and with two, and how memory grows with the number of scenarios.

    python benchmarks/batch.py --count 1000 --sweep 10000

The small scenarios roll the swimmer by 1 to 20 degrees on the spot, with --effort quick. The sweep's keep
bent limbs where they are, so that what is measured is the batch and not the planner. Memory is the largest
resident size of the batch's own process; a worker's is that of one plan.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

_MAIN = """
import json, resource, sys
from purcell_cli.cli import _run
code = _run(["batch", *sys.argv[1:]])
peak = [resource.getrusage(who).ru_maxrss / 1024.0 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
print(json.dumps({"code": code, "batch_mb": peak[0], "worker_mb": peak[1]}), file=sys.stderr)
"""

_ROLL = """
name: roll
start: {}
goal: {base: {orientation: {euler_deg: [0, 0, 0]}}}
sweep: {'goal.base.orientation.euler_deg[2]': {start: 1, stop: 20, num: COUNT}}
"""

_STILL = """
name: still
start: {limb1: {euler_deg: [0, 10, 0]}}
goal: {limb1: {euler_deg: [0, 10, 0]}}
sweep: {swimmer.viscosity_pa_s: {start: 0.5, stop: 1.5, num: COUNT}}
"""


def run(text: str, count: int, jobs: int, *options: str) -> dict[str, float]:
    """Run a batch of a number of scenarios in a process of its own, and return what it took."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "case.yaml").write_text(text.replace("COUNT", str(count)))
        begun = time.perf_counter()
        done = subprocess.run(  # noqa: S603  # this very program
            [sys.executable, "-c", _MAIN, "case.yaml", "--jobs", str(jobs), "--effort", "quick", "--json", *options],
            cwd=folder,
            capture_output=True,
            text=True,
            check=True,
            env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )
        seconds = time.perf_counter() - begun
    told, found = json.loads(done.stdout), json.loads(done.stderr.splitlines()[-1])
    if (told["scenarios"], told["failed"], found["code"]) != (count, 0, 0):
        raise SystemExit(f"wanted {count} scenarios that hold, found {told}")
    return {"seconds": seconds, "rate": count / seconds, **found}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000, help="small scenarios")
    parser.add_argument("--sweep", type=int, default=10000, help="scenarios of the sweep")
    asked = parser.parse_args()
    rates = []
    for jobs in (1, 2):
        found = run(_ROLL, asked.count, jobs)
        rates.append(found["rate"])
        load = os.getloadavg()[0]
        print(
            f"{asked.count} small scenarios, {jobs} workers: {found['seconds']:.1f} s, {found['rate']:.2f} a second, "
            f"batch {found['batch_mb']:.0f} MB, worker {found['worker_mb']:.0f} MB (load {load:.1f})",
            flush=True,
        )
    print(f"two workers are {rates[1] / rates[0]:.2f} times as fast as one")
    for count in (asked.sweep // 10, asked.sweep):
        found = run(_STILL, count, 2, "--no-trajectories", "--parquet")
        print(
            f"sweep of {count}: {found['seconds']:.1f} s, {found['rate']:.1f} a second, "
            f"batch {found['batch_mb']:.0f} MB, worker {found['worker_mb']:.0f} MB",
            flush=True,
        )


if __name__ == "__main__":
    main()
