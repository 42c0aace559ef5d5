"""Batches: found, solved, judged and summed up, whatever the order in which workers finish."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path

import polars as pl
import pytest
from batches import QUICK, results, roll, rows, still, written
from helpers import Run, runner
from lxml import etree

from purcell_cli import load_plan, read_csv
from purcell_cli.batch.cases import find_cases
from purcell_cli.batch.expectations import fraction
from purcell_cli.batch.results_folder import ResultsFolder
from purcell_cli.errors import InputError, ParameterError

DATA = Path(__file__).parent / "data"


MIXED = [
    roll("slowest-first", 9, "expect: {max_joint_travel_rad: 5, max_duration_s: 5, min_clearance_m: 0.1}"),
    still("good", 10, "expect: {position_tolerance: 1.0e-9, angle_tolerance_rad: 1.0e-9}"),
    roll("too-far", 5, "expect: {max_joint_travel_rad: 0.001}"),
    roll("too-slow", 5, "expect: {max_duration_s: 0.001}"),
    still("too-near", 10, "expect: {min_clearance_m: 10}"),
    still("not-refused", 10, "expect: {verdict: error}"),
    "name: refused\nstart: {limb1: {matrix: [[2, 0, 0], [0, 1, 0], [0, 0, 1]]}}\ngoal: {}\nexpect: {verdict: error}",
    "name: refused-late\nstart: {limb1: {euler_deg: [180, 0, 0]}, limb2: {euler_deg: [180, 0, 0]}}\ngoal: {}\n"
    "expect: {error: clearance}",
    "name: refused-otherwise\nstart: {limb3: {}}\ngoal: {}\nexpect: {error: clearance}",
    "name: [broken\n",
    still("<&>", 10),
]
KEYS = {
    *("schema", "verdict", "scenarios", "solved", "failed", "crashed", "compared", "vanished", "failures"),
    *("wall_time_s", "folder", "junit", "passed_over"),
}
FAILED = {
    "too-far": "joint travel: wanted at most 0.001 rad",
    "too-slow": "duration: wanted at most 0.001 s",
    "too-near": "clearance: wanted at least 10 m",
    "not-refused": "verdict: wanted error, found reached",
    "refused-otherwise": "error: wanted a message with 'clearance'",
    "009": "verdict: wanted reached, found error (scenarios/009.yaml:2: name",
    "010": "a name (at most 100 letters",
}


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs a batch in an empty folder: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    return runner(capsys, "batch", *QUICK)


@pytest.mark.slow
def test_each_scenario_is_judged_and_a_failing_one_stops_no_other(run: Run, tmp_path: Path) -> None:
    written(tmp_path / "scenarios", MIXED)
    code, out, err = run("scenarios", "--jobs", "2", "--junit", "report.xml", "--parquet", "--json")
    document = json.loads(out)
    assert (code, document["verdict"]) == (1, "failed")
    assert set(document) == KEYS
    assert (document["scenarios"], document["failed"], document["crashed"]) == (11, 7, 0)
    assert all(set(failure) == {"name", "file", "verdict", "reasons"} for failure in document["failures"])
    assert {f["name"] for f in document["failures"]} == set(FAILED)
    for failure in document["failures"]:
        assert any(FAILED[failure["name"]] in reason for reason in failure["reasons"]), failure
        assert failure["name"] in err
    found = rows(tmp_path / "purcell-results")
    assert list(found)[:3] == ["slowest-first", "good", "too-far"], "the order is that of the files"
    assert {name for name, row in found.items() if row["passed"]} == set(found) - set(FAILED)

    # The files of a scenario: a plan that reads back, and the very motion that the summary tells of.
    plan = load_plan("purcell-results/slowest-first.json").plan
    table = read_csv("purcell-results/slowest-first.csv")
    assert plan.joint_travel_rad == found["slowest-first"]["joint_travel_rad"]
    assert table.time_s[-1] == pytest.approx(found["slowest-first"]["duration_s"], rel=1e-9)
    assert len(table.time_s) == found["slowest-first"]["rows"]
    assert not (tmp_path / "purcell-results" / "refused.json").exists()

    # The three summaries say the same.
    with (tmp_path / "purcell-results" / "summary.csv").open(newline="") as stream:
        lines = list(csv.DictReader(stream))
    frame = pl.read_parquet("purcell-results/summary.parquet").to_dicts()
    assert [line["name"] for line in lines] == list(found) == [row["name"] for row in frame]
    for line, row in zip(lines, frame, strict=True):
        wanted = found[row["name"]]
        assert (line["passed"], row["passed"]) == (str(wanted["passed"]).lower(), wanted["passed"])
        assert line["joint_travel_rad"] == ("" if wanted["rows"] is None else repr(wanted["joint_travel_rad"]))
        assert (row["joint_travel_rad"], row["rows"]) == (wanted["joint_travel_rad"], wanted["rows"])

    # The report is valid, and tells of each failure why.
    schema = etree.XMLSchema(etree.parse(DATA / "junit.xsd"))
    report = etree.parse(tmp_path / "report.xml")
    schema.assertValid(report)
    assert [case.get("name") for case in report.iter("testcase")] == list(found)
    assert {case.get("name"): case[0].tag for case in report.iter("testcase") if len(case)} == dict.fromkeys(
        FAILED, "failure"
    )
    assert FAILED["too-far"] in report.find(".//testcase[@name='too-far']/failure").text
    suite = report.find("testsuite")
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("11", "7", "0")
    del suite.attrib["timestamp"]
    assert not schema.validate(report), "the schema sees what is missing"


@pytest.mark.slow
def test_bytes_are_the_same_from_run_to_run_and_for_any_number_of_workers(run: Run, tmp_path: Path) -> None:
    written(tmp_path / "s", [roll("a", 9), still("b", 10), roll("c", 3), still("d", 20)])
    assert run("s", "--out", "one", "--jobs", "1")[0] == 0
    assert run("s", "--out", "two", "--jobs", "3")[0] == 0
    assert results(tmp_path / "one") == results(tmp_path / "two")
    assert {"a.csv", "a.json", "summary.csv", "summary.json"} <= set(results(tmp_path / "one"))
    code, out, _ = run("s", "--out", "three", "--no-trajectories", "--filter", "[ab]")
    assert code == 0
    assert "2 scenarios" in out
    assert {p.name for p in (tmp_path / "three").glob("[!.]*")} == {"a.json", "b.json", "summary.csv", "summary.json"}


@pytest.mark.slow
def test_a_finished_batch_is_not_done_again_and_a_changed_scenario_is(run: Run, tmp_path: Path) -> None:
    folder = written(tmp_path / "s", [roll("a", 9), still("b", 10)])
    assert run("s", "--json")[0] == 0
    before = results(tmp_path / "purcell-results")
    code, out, _ = run("s", "--json", "--resume")
    assert (code, json.loads(out)["solved"]) == (0, 0)
    assert run("s", "--resume")[2] == "2 of 2 scenarios, all finished before\n"
    assert results(tmp_path / "purcell-results") == before
    (folder / "001.yaml").write_text(still("b", 11))
    (tmp_path / "purcell-results" / "a.csv").write_text("torn by a power cut")
    assert json.loads(run("s", "--json", "--resume")[1])["solved"] == 2
    assert results(tmp_path / "purcell-results")["a.csv"] == before["a.csv"]
    assert results(tmp_path / "purcell-results")["b.json"] != before["b.json"]


@pytest.mark.slow
def test_a_regression_against_an_earlier_run_fails_and_is_named(run: Run, tmp_path: Path) -> None:
    written(tmp_path / "s", [roll("a", 9), roll("b", 3), still("c", 3)])
    assert run("s")[0] == 0
    summary = tmp_path / "purcell-results" / "summary.json"
    earlier = json.loads(summary.read_text())
    for row, factor in zip(earlier["rows"], (0.9, 0.96, 1.0), strict=True):
        row["joint_travel_rad"] *= factor
        row["base_error_rad"] *= 0.001  # round-off: no regression
    (tmp_path / "earlier.json").write_text(json.dumps(earlier))
    code, out, _ = run("s", "--resume", "--json", "--baseline", "earlier.json", "--max-regress", "5%")
    document = json.loads(out)
    assert (code, document["solved"], document["compared"]) == (1, 0, 3)
    assert [failure["name"] for failure in document["failures"]] == ["a"]
    assert "11.1 % more than" in document["failures"][0]["reasons"][0]
    assert run("s", "--resume", "--baseline", "earlier.json", "--max-regress", "0.2")[0] == 0
    code, out, err = run("s", "--resume", "--baseline", "earlier.json", "--max-regress", "many")
    assert (code, out) == (2, "")
    assert "--max-regress: a part such as 5%" in err
    (tmp_path / "earlier.json").write_text('{"rows": [{"name": "a"}]}')
    assert run("s", "--resume", "--baseline", "earlier.json")[0] == 2


@pytest.mark.slow
def test_a_baseline_shares_scenarios_and_those_that_are_gone_are_named(run: Run, tmp_path: Path) -> None:
    folder = written(tmp_path / "s", [still("a", 9), still("b", 10)])
    assert run("s")[0] == 0
    summary = (tmp_path / "purcell-results" / "summary.json").read_text()
    (tmp_path / "earlier.json").write_text("\ufeff" + summary)
    (folder / "001.yaml").write_text(still("c", 10))
    code, out, err = run("s", "--baseline", "earlier.json", "--json")
    document = json.loads(out)
    assert (code, document["compared"], document["vanished"]) == (0, 1, ["b"])
    assert "warning: 1 scenario of the baseline not in this batch: b\n" in err
    code, out, err = run("s", "--baseline", "earlier.json", "--json", "--filter", "a")
    assert (json.loads(out)["vanished"], "warning" in err) == ([], False)
    (tmp_path / "other.json").write_text("{}")
    assert (
        "other.json: wanted the summary.json of a batch, found no key 'rows'" in run("s", "--baseline", "other.json")[2]
    )
    (folder / "000.yaml").unlink()
    before = results(tmp_path / "purcell-results")
    code, out, err = run("s", "--baseline", "earlier.json")
    assert (code, out) == (2, "")
    assert "--baseline: wanted an earlier run with a scenario of this batch, found 2 scenarios of other names" in err
    assert results(tmp_path / "purcell-results") == before


@pytest.mark.parametrize(
    ("text", "value"),
    [("5%", 0.05), ("0.05", 0.05), ("5 %", 0.05), ("1", 1.0), ("0", 0.0), ("150%", 1.5), (".5", 0.5), ("1e1%", 0.1)],
)
def test_a_part_is_a_fraction_or_a_percentage(text: str, value: float) -> None:
    assert fraction(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["5", "1.01", "100", "1e3"])
def test_a_percentage_without_its_sign_is_refused(text: str) -> None:
    with pytest.raises(
        ParameterError, match=f"a percentage with its sign \\({text}% or .*found '{text}', which would be"
    ):
        fraction(text)


@pytest.mark.parametrize("text", ["many", "", "%", "-5%", "nan", "inf", "1_0%", "5%%", "5 % 3", "\u0665%", "1e9%"])
def test_what_is_no_part_is_refused(text: str) -> None:
    with pytest.raises(ParameterError, match=r"a part such as 5% or 0\.05 is wanted"):
        fraction(text)


@pytest.mark.slow
def test_files_without_a_name_fail_one_by_one(run: Run, tmp_path: Path) -> None:
    """Two that would get one name, two that lead round, and one whose file is called as the summary."""
    for folder in ("s/a", "s/b"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "x.yaml").write_text("[")
        (tmp_path / folder / "y.yaml").write_text("name: [1]\nstart: {}\ngoal: {}\n")
    (tmp_path / "s" / "round.yaml").symlink_to("other.yaml")
    (tmp_path / "s" / "other.yaml").symlink_to("round.yaml")
    (tmp_path / "s" / "summary.yaml").write_text("start: {}\ngoal: {}\n")
    (tmp_path / "s" / "z.yaml").write_text(still("x-2", 5))
    code, out, _ = run("s", "--json")
    document = json.loads(out)
    assert (code, document["scenarios"], document["failed"]) == (1, 8, 7)
    names = {row["name"]: row["file"] for row in document["failures"]}
    assert names == {
        "other": "s/other.yaml", "round": "s/round.yaml", "summary-2": "s/summary.yaml", "x": "s/a/x.yaml",
        "y": "s/a/y.yaml", "x-3": "s/b/x.yaml", "y-2": "s/b/y.yaml",
    }  # fmt: skip
    assert rows(tmp_path / "purcell-results")["x-2"]["passed"]


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="other systems do not take such names")
def test_the_folder_of_results_may_have_any_name(run: Run, tmp_path: Path) -> None:
    """Beside it stands what its name means as a pattern."""
    written(tmp_path / "s", [still("a", 9)])
    (tmp_path / "res1").mkdir()
    (tmp_path / "res1" / "summary.csv").write_text("other")
    for folder in ("res[1]", "~", "a%20b", "{a,b}*"):
        assert run("s", "--out", folder, "--parquet")[0] == 0
        with (tmp_path / folder / "summary.parquet").open("rb") as stream:
            assert pl.read_parquet(stream)["name"].to_list() == ["a"]


@pytest.mark.slow
def test_a_measured_orientation_is_warned_of_once(run: Run, tmp_path: Path) -> None:
    rough = "{limb1: {quaternion_wxyz: [0.707, 0, 0, 0.707]}}"
    written(tmp_path / "s", [f"name: n{k}\nstart: part.yaml\ngoal: {rough}" for k in range(2)])
    (tmp_path / "s" / "part.yaml").write_text(rough)
    code, out, err = run("s", "--json")
    assert (code, json.loads(out)["passed_over"]) == (0, 1)
    told = [line for line in err.splitlines() if "warning" in line]
    assert [line.partition("warning: ")[2].split(": ")[0] for line in told] == [
        "s/part.yaml:1", "s/000.yaml:3", "s/001.yaml:3",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "found none"),
        (["*.nothing"], "a pattern that files fit"),
        (["s", "--filter", "nobody"], "whose name has 'nobody'"),
        (["s", "--effort", "enormous"], "effort: one of"),
        (["s", "--dt", "-1"], "dt"),
        (["s", "twin"], "which s/000.yaml has too"),
        (["reserved"], "which the summary has"),
        (["s", "--junit", "no/report.xml"], "no folder no"),
    ],
)
def test_misuse_is_refused_and_no_results_are_written(
    run: Run, tmp_path: Path, arguments: list[str], message: str
) -> None:
    written(tmp_path / "s", [still("a", 1)])
    written(tmp_path / "twin", [still("A", 1)])
    written(tmp_path / "reserved", [still("Summary", 1)])
    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert not list(tmp_path.glob("purcell-results/[!.]*"))


@pytest.mark.slow
def test_two_batches_cannot_write_into_one_folder(run: Run, tmp_path: Path) -> None:
    written(tmp_path / "s", [still("a", 1)])
    with ResultsFolder(tmp_path / "purcell-results"):
        code, out, err = run("s")
        assert (code, out) == (2, "")
        assert "another batch at work" in err
    assert run("s")[0] == 0


def test_folders_patterns_files_and_stored_names_are_found_once_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "s", [still("a", 1), still("b", 1)])
    written(tmp_path / "s" / "deep", [still("c", 1)])
    written(tmp_path / "s" / ".hidden", [still("d", 1)])
    (tmp_path / "s" / "start.yaml").write_text("limb1: {euler_deg: [10, 0, 0]}")
    (tmp_path / "s" / "swimmer.yml").write_text("slenderness: 0.02")
    (tmp_path / "s" / "typo.yaml").write_text("slendernes: 0.02")
    (tmp_path / "loop").symlink_to(tmp_path)
    cases = find_cases(["s", "s/*.yaml", "s/000.yaml", "nearby"])
    assert [case.name for case in cases] == ["a", "b", "typo", "c", "nearby"]
    assert (cases.count, cases.passed_over) == (5, 3), "a file that is almost a swimmer is not passed over"
    assert [case.name for case in find_cases(["s"], "c")] == ["c"]
    with pytest.raises(InputError, match="found none"):
        find_cases(["empty"])


@pytest.mark.parametrize("name", ["../evil", "/tmp/evil", "a/b", "..", "", "a\\b", "nul\0", "x" * 101])
def test_no_name_leads_out_of_the_folder(tmp_path: Path, name: str) -> None:
    written(tmp_path / "s", [f"name: {json.dumps(name)}\nstart: {{}}\ngoal: {{}}"])
    (case,) = find_cases([str(tmp_path / "s")])
    assert case.name == "000"
    assert case.scenario is None
