"""What the tests of batches share: small scenarios, batches as processes, and results compared but for times."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

QUICK = ("--effort", "quick")

_MAIN = "import sys; from purcell_cli.cli.app import main; sys.argv[0] = 'purcell'; main()"


def roll(name: str, degrees: float, extra: str = "") -> str:
    """Return a scenario that takes a tenth of a second: a roll on the spot."""
    return f"name: {name}\nstart: {{}}\ngoal: {{base: {{orientation: {{euler_deg: [0, 0, {degrees}]}}}}}}\n{extra}"


def still(name: str, degrees: float, extra: str = "") -> str:
    """Return a scenario that takes some milliseconds: bent limbs that stay as they are."""
    bent = f"{{limb1: {{euler_deg: [{degrees}, 0, 0]}}}}"
    return f"name: {name}\nstart: {bent}\ngoal: {bent}\n{extra}"


def written(folder: Path, scenarios: list[str]) -> Path:
    """Write scenarios into a folder, in their order, and return it."""
    folder.mkdir(exist_ok=True)
    for k, text in enumerate(scenarios):
        (folder / f"{k:03d}.yaml").write_text(text)
    return folder


def process(*arguments: str, cwd: Path, **options: Any) -> subprocess.Popen[str]:
    """Start a batch as a process of its own, in a session of its own.

    It leaves no compiled modules: those that a full disk cut short would break every process after it.
    """
    alone = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.Popen(
        [sys.executable, "-c", _MAIN, "batch", *QUICK, *arguments],
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env=os.environ | alone,
        **options,
    )


def results(folder: Path) -> dict[str, bytes]:
    """Return the files in a folder of results, hidden ones too, with every time taken out."""
    out = {}
    for path in sorted(folder.iterdir()):
        data = path.read_bytes()
        if path.name == "summary.csv":
            data = b"\n".join(line.rpartition(b",")[0] for line in data.splitlines())
        elif path.name in {"summary.json", ".purcell-batch.jsonl"}:
            data = re.sub(rb'"wall_time_s": [-0-9.e]+', b"", data)
        out[path.name] = data
    return out


def rows(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the rows of a summary by name, in order."""
    return {row["name"]: row for row in json.loads((folder / "summary.json").read_text())["rows"]}
