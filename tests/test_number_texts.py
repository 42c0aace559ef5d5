"""Numbers as text: the fewest digits that read back as the same double."""

from __future__ import annotations

import csv
import io
import re

import numpy as np
import polars as pl

from purcell_cli.files.trajectory_csv import COLUMNS, write_rows
from purcell_cli.motion.trajectory import Trajectory

POWERS = np.concatenate([2.0 ** np.arange(-1074, 1024), 10.0 ** np.arange(-323, 309)])
SPECIAL = np.array([0.0, -0.0, 1e-5, 9.999999999999999e-6, 1e15, 1e16, 1.5e16, 5e-324, np.finfo(float).max, 0.1 + 0.2])


def numbers() -> np.ndarray:
    rng = np.random.default_rng(5)
    bits = rng.integers(0, 1 << 63, 5000, dtype=np.uint64).view(np.float64)
    near = rng.normal(size=5000) * 10.0 ** rng.integers(-8, 18, 5000)
    found = np.concatenate([bits, near, np.round(near, 3), POWERS, np.nextafter(POWERS, np.inf), -POWERS, SPECIAL])
    return found[np.isfinite(found)]


def texts(values: np.ndarray) -> list[str]:
    """Each number as a file has it: the rates about x of limb 1, in a row each."""
    n = len(values)
    still, rates = np.tile(np.eye(3), (n, 2, 1, 1)), np.zeros((n, 6))
    rates[:, 0] = values
    rows = Trajectory(
        np.zeros(n), np.ones(n, int), np.zeros(n, int), ("a",), np.tile(np.eye(4), (n, 1, 1)), still, rates
    )
    stream = io.BytesIO()
    write_rows(rows, stream)
    return [line.split(",")[-6] for line in stream.getvalue().decode().splitlines()[1:]]


def digits(text: str) -> str:
    return re.sub(r"e.*|\D", "", text).strip("0")


def wrong(found: list[str], values: np.ndarray) -> int:
    """How many are not the shortest text of their double, by Python's own."""
    pairs = zip(found, values.tolist(), strict=True)
    return sum(float(text) != value or digits(text) != digits(repr(value)) for text, value in pairs)


def test_numbers_have_the_fewest_digits_that_read_back_as_the_same_double() -> None:
    values = numbers()
    assert wrong(texts(values), values) == 0
    # as seventeen digits have not:
    assert wrong([f"{value:.16e}" for value in values.tolist()], values) > 0.3 * len(values)


def test_numbers_look_as_those_of_the_table_package_do() -> None:
    values = numbers()
    values = values[np.abs(values) < 1e16] + 0.0  # beyond, packages differ in the sign of an exponent
    assert "\n".join(texts(values)) + "\n" == pl.DataFrame({"a": values}).write_csv(include_header=False)


def test_a_stroke_with_any_name_is_read_back() -> None:
    names = ('comma, "and" mark', "", "line\nend", "plain")
    n = len(names)
    still = np.tile(np.eye(3), (n, 2, 1, 1))
    kind = np.arange(n)
    rows = Trajectory(kind * 0.5, np.ones(n, int), kind, names, np.tile(np.eye(4), (n, 1, 1)), still, np.zeros((n, 6)))
    stream = io.BytesIO()
    write_rows(rows, stream)
    found = list(csv.DictReader(io.StringIO(stream.getvalue().decode(), newline="")))
    assert tuple(found[0]) == COLUMNS
    assert [row["gait"] for row in found] == list(names)
    assert [row["t_s"] for row in found] == ["0.0", "0.5", "1.0", "1.5"]
    assert [row["phase"] for row in found] == ["1"] * n
