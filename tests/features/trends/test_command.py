"""`trend` and `index rebuild` as commands."""

import csv
import json

import pytest

from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.features.trends.schema import TrendReport
from tests.kit.command_line import here
from tests.kit.fit_tables import read_fits
from tests.kit.specimen_months import months, procedure


@pytest.mark.long
def test_a_trend_is_told_drawn_and_written(tmp_path):
    months(tmp_path, 70)
    files = ("--png", tmp_path / "t.png", "--csv", tmp_path / "t.csv", "--json", tmp_path / "t.json")
    told = here("trend", "T 1", "--recordings", tmp_path, *files)
    assert told.returncode == 0, told.stderr
    assert "now: lost_magnetisation since 2026-03-13" in told.stdout
    assert "once in 20000 points" in told.stdout
    assert (tmp_path / "t.png").read_bytes().startswith(b"\x89PNG")
    report = TrendReport.model_validate_json((tmp_path / "t.json").read_text())
    rows = list(csv.DictReader((tmp_path / "t.csv").open()))
    assert len(rows) == len(report.points) == 70
    f_nat = next(chart for chart in report.charts if chart.quantity == "f_nat_hz")
    assert [float(row["f_nat_hz"]) for row in rows] == list(f_nat.value)
    assert json.loads((tmp_path / "t.json").read_text())["specimen"] == "T 1"
    accepted = here(
        "trend", "T 1", "--recordings", tmp_path, "--accept", "new", "--by", "DC", "--since", "2026-03-13T12"
    )
    assert accepted.stdout.splitlines()[0] == "accepted as it is since 2026-03-13T12:00:00.000+00:00"
    assert "no change beyond chance" in accepted.stdout
    again = here("trend", "T 1", "--recordings", tmp_path, "--png", tmp_path / "t.png")
    assert again.returncode == 2
    assert "exists already" in again.stderr


def test_bad_input_is_one_line(tmp_path):
    months(tmp_path, 1)
    (tmp_path / "broken.h5").write_text("no")
    for arguments, said in (
        (("trend", "nobody", "--recordings", tmp_path), "no recording is of 'nobody'"),
        (("trend", "T 1", "--recordings", tmp_path / "none"), "is no folder"),
        (("trend", "T 1", "--recordings", tmp_path, "--since", "x"), "no time of ISO 8601"),
        (("trend", "T 1", "--recordings", tmp_path, "--points-to-false-alarm", "3"), "false alarm"),
        (("trend", "T 1", "--recordings", tmp_path, "--accept", "new"), "error: --by: no person is named"),
        (("trend", "T 1", "--recordings", tmp_path, "--accept", " ", "--by", "DC"), "error: --accept: says no reason"),
        (("trend", "T 1", "--recordings", tmp_path, "--since", "2026-11-26", "--until", "2026-11-25"), "is before"),
        (("index", "find", "--recordings", tmp_path, "--since", "2026-11-26", "--until", "2026-11-25"), "is before"),
        (("index", "export", "T 1", "--recordings", tmp_path, "--csv", "-"), "error: -: is no file"),
        (("index", "rebuild", "--recordings", tmp_path / "none"), "is no folder"),
    ):
        told = here(*arguments)
        assert told.returncode == 2, told.stdout
        assert said in told.stderr.splitlines()[-1]
    told = here("index", "rebuild", "--recordings", tmp_path)
    assert told.stdout == "2 files looked at\n"
    assert "broken.h5: not an HDF5 file" in told.stderr


def test_a_time_without_points_is_told_as_such(tmp_path):
    months(tmp_path, 1)
    told = here("trend", "T 1", "--recordings", tmp_path, "--since", "2027-01-01")
    assert told.returncode == 0, told.stderr
    assert "no points in that time" in told.stdout
    assert "beyond chance" not in told.stdout


def test_a_trend_is_of_the_last_step_of_procedures_or_of_the_one_that_is_named(tmp_path):
    months(tmp_path, 1)
    tune, ramp, series = StepLabel(1, {}, "tune"), StepLabel(2, {"field_ut": 240.0}, "ramp"), StepLabel(3, {}, "series")
    procedure(tmp_path, "whole", [tune, ramp, series], [209.0, 211.0, 213.0])
    procedure(tmp_path, "cut", [tune], [208.0])

    def told(*more):
        done = here("trend", "T 1", "--recordings", tmp_path, "--json", tmp_path / "t.json", "--force", *more)
        if done.returncode:
            return done.stderr.splitlines()[-1]
        report = TrendReport.model_validate_json((tmp_path / "t.json").read_text())
        f_nat = next(chart for chart in report.charts if chart.quantity == "f_nat_hz")
        values = dict(zip([point.recording for point in report.points], f_nat.value, strict=True))
        return values.get("whole"), values.get("cut"), "T-1-000" in values, " ".join(report.notes)

    assert told()[:3] == (213.0, 208.0, True)
    whole, cut, series_stays, notes = told("--step", "ramp")
    assert (whole, cut, series_stays) == (211.0, None, True)
    assert "step 2 (ramp, field_ut = 240)" in notes
    assert "left out, because they have no step 'ramp': cut" in notes
    assert told("--step", "1")[:2] == (209.0, 208.0)
    assert "no procedure of this specimen has a step 'sweep'. Remedy: name one of " in told("--step", "sweep")
    assert "one step of each procedure" in told("--step", "all")


def test_points_in_simulated_time_are_told_as_such(tmp_path):
    months(tmp_path, 2)
    months(tmp_path, 3, "T 2", clock="simulated")

    def told(specimen):
        files = ("--json", tmp_path / "t.json", "--csv", tmp_path / "t.csv", "--force")
        done = here("trend", specimen, "--recordings", tmp_path, *files)
        assert done.returncode == 0, done.stderr
        rows = csv.DictReader((tmp_path / "t.csv").open())
        report = TrendReport.model_validate_json((tmp_path / "t.json").read_text())
        return done.stdout, [row["clock"] for row in rows], [point.clock for point in report.points]

    text, in_table, in_report = told("T 2")
    assert "note: all points are in simulated time" in text
    assert in_table == in_report == ["simulated"] * 3
    text, in_table, in_report = told("T 1")
    assert "simulated" not in text
    assert (in_table, in_report) == (["", ""], [None, None])
    assert told("T 1")[0] == text  # from the index, too


def test_files_are_found(tmp_path):
    months(tmp_path, 3)
    told = here("index", "find", "--recordings", tmp_path, "--specimen", "T 1", "--since", "2026-03-01T05:00")
    assert told.stdout.split() == [str(tmp_path / "T-1-001.h5"), str(tmp_path / "T-1-002.h5")]
    assert here("index", "find", "--recordings", tmp_path, "--refused").stdout == ""


def test_the_fits_of_a_specimen_are_one_table(tmp_path):
    made = months(tmp_path, 3)
    told = here("index", "export", "T 1", "--csv", tmp_path / "fits.csv", "--recordings", tmp_path)
    assert told.stdout == f"3 fits in {tmp_path / 'fits.csv'}\n", told.stderr
    rows = list(csv.DictReader((tmp_path / "fits.csv").open()))
    assert [row["recording"] for row in rows] == [path.stem for path in made]
    assert [float(row["f_nat_hz"]) for row in rows] == [read_fits(path)[0].values[0, 0] for path in made]
    assert {(row["f_nat_hz_std"], row["m_r_am2_std"], row["verdict"]) for row in rows} == {("0.001", "1e-06", "good")}
    assert [float(row["nrmse"]) for row in rows] == [read_fits(path)[0].nrmse[0] for path in made]
    pyarrow = pytest.importorskip("pyarrow.parquet")
    assert here("index", "export", "T 1", "--parquet", tmp_path / "f.parquet", "--recordings", tmp_path).returncode == 0
    table = pyarrow.read_table(tmp_path / "f.parquet").to_pylist()
    assert [row["f_nat_hz"] for row in table] == [float(row["f_nat_hz"]) for row in rows]
    assert [row["at"].isoformat() for row in table] == [row["at"] for row in rows]
    assert {row["reason"] for row in table} == {None}
    assert here("index", "export", "T 1", "--recordings", tmp_path).returncode == 2
    assert here("index", "export", "x", "--csv", tmp_path / "x.csv", "--recordings", tmp_path).returncode == 2
    assert not (tmp_path / "x.csv").exists()
