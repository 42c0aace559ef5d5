"""Numbers as text: the fewest digits that read back as the same double."""

from __future__ import annotations

import csv
import io
import re

import numpy as np
import polars as pl
import pytest

from purcell_cli.files.trajectory_csv import COLUMNS, write_rows
from purcell_cli.kernel.decimals import rows_as_text
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
    return rows_as_text(values[:, None], [""], np.zeros(len(values), dtype=np.int64)).decode().split("\n")[:-1]


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
    values = values[np.abs(values) < 1e16]  # beyond, packages differ in the sign of an exponent
    assert "\n".join(texts(values)) + "\n" == pl.DataFrame({"a": values}).write_csv(include_header=False)
    assert texts(np.array([1e16, np.inf, -np.inf, np.nan])) == ["1e+16", "inf", "-inf", "NaN"]


def test_words_stand_after_the_first_number_of_a_row() -> None:
    text = rows_as_text([[1.0, 2.5], [0.25, -3.0], [1e-7, 0.0]], [",no", "", ",yes,é"], [2, 1, 0])
    assert text.decode() == "1.0,yes,é,2.5\n0.25,-3.0\n1e-7,no,0.0\n"
    assert rows_as_text(np.empty((0, 3)), [], []) == b""
    for which in ([0, 3], [-1, 0]):
        with pytest.raises(ValueError, match="words 0 to 2"):
            rows_as_text([[1.0], [2.0]], ["a", "b", "c"], which)
    with pytest.raises(ValueError, match="which"):
        rows_as_text([[1.0], [2.0]], ["a"], [0])


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
