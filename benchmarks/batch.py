"""Batches: scenarios a second with one worker and with two, and how memory grows with the number of scenarios.

    python benchmarks/batch.py --count 1000 --sweep 10000

The small scenarios, the sweep's too, roll the swimmer by 1 to 20 degrees on the spot, with --effort quick. Memory is
the largest resident size of the batch's own process, and that of a worker. Processor time is told beside the clock's:
on a machine that others use too it says what the clock cannot, how much of the work only the batch itself can do.
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
from purcell_cli.cli.app import _run
code = _run(["batch", *sys.argv[1:]])
used = {"batch": resource.getrusage(resource.RUSAGE_SELF), "worker": resource.getrusage(resource.RUSAGE_CHILDREN)}
found = {f"{who}_mb": use.ru_maxrss / 1024.0 for who, use in used.items()}
found |= {f"{who}_cpu_s": use.ru_utime + use.ru_stime for who, use in used.items()}
print(json.dumps({"code": code, **found}), file=sys.stderr)
"""

ROLL = """
name: roll
start: {}
goal: {base: {orientation: {euler_deg: [0, 0, 0]}}}
sweep: {'goal.base.orientation.euler_deg[2]': {start: 1, stop: 20, num: COUNT}}
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


def told(found: dict[str, float]) -> str:
    """Return the figures of a batch in words."""
    return (
        f"{found['seconds']:.1f} s, {found['rate']:.2f} a second; processor time {found['batch_cpu_s']:.1f} s "
        f"in the batch, {found['worker_cpu_s']:.1f} s in workers; "
        f"memory {found['batch_mb']:.0f} MB, {found['worker_mb']:.0f} MB (load {os.getloadavg()[0]:.1f})"
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000, help="small scenarios")
    parser.add_argument("--sweep", type=int, default=10000, help="scenarios of the sweep; 0 for no sweep")
    asked = parser.parse_args()
    rates = []
    for jobs in (1, 2):
        found = run(ROLL, asked.count, jobs)
        rates.append(found["rate"])
        print(f"{asked.count} small scenarios, --jobs {jobs}: {told(found)}", flush=True)
    print(f"two workers are {rates[1] / rates[0]:.2f} times as fast as one")
    for count in (asked.sweep // 10, asked.sweep) if asked.sweep else ():
        found = run(ROLL, count, 2, "--no-trajectories", "--parquet")
        print(f"sweep of {count}: {told(found)}", flush=True)


if __name__ == "__main__":
    main()
