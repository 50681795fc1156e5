"""Tables as CSV: names of columns, form of cells, and the rules of result files."""

import csv
import io
import json
import math

import pytest

from platform_daemon.core.command_line.csv_table import csv_text
from platform_daemon.core.schemas.fits import FitReport, NoiseReport, ParameterEstimate
from platform_daemon.features.fit.report import fit_rows
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.frame_fits import good_frame
from tests.kit.recording_files import fit_table, write_series


def rows_of(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_a_column_is_named_by_the_path_of_its_value_in_json():
    text = csv_text([{"frame": 0, "f_nat_hz": ParameterEstimate(value=213.148, std=None).model_dump()}])
    assert text == "frame,f_nat_hz.value,f_nat_hz.std\n0,213.148,\n"


@pytest.mark.parametrize(
    ("typed", "written"),
    [("=1+1", "'=1+1"), ("@SUM(A1)", "'@SUM(A1)"), ("-5 K", "'-5 K"), ("-0.5", "-0.5"), ("T=1", "T=1")],
)
def test_what_a_person_typed_is_no_formula(typed, written):
    assert csv_text([{"sample": typed}]) == f"sample\n{written}\n"


def test_numbers_are_those_of_json_and_what_an_entry_lacks_is_empty():
    text = csv_text([{"a_s": 0.1 + 0.2, "said": 'with "," in it'}, {"axis": (1.0, 0.0), "late": True}])
    first, second = rows_of(text)
    assert first == {"a_s": "0.30000000000000004", "said": 'with "," in it', "axis": "", "late": ""}
    assert (json.loads(second["axis"]), second["late"]) == ([1.0, 0.0], "true")


def test_what_json_cannot_hold_is_refused():
    with pytest.raises(ValueError, match="JSON"):
        csv_text([{"a_s": math.nan}])


def test_a_table_of_fits_has_a_row_per_frame_and_no_covariance():
    frames = (good_frame(0, f_nat_hz=213.1), good_frame(1, f_nat_hz=213.2))
    report = FitReport(
        file="a.h5", variant="jewel", window="n50", window_s=0.24, calibration=None, notes=(),
        noise=NoiseReport(source=None, seconds=0.0), frames=frames, summary={}, systematic_std={},
    )  # fmt: skip
    found = rows_of(csv_text(fit_rows(report)))
    assert [row["parameters.f_nat_hz.value"] for row in found] == ["213.1", "213.2"]
    assert {(row["file"], row["window"]) for row in found} == {("a.h5", "n50")}
    assert not any(name.startswith("covariance") for name in found[0])


@pytest.mark.parametrize(
    ("command", "key", "column"),
    [
        (("devices",), "devices", "device"),
        (("predict", "--resonator", "jewel"), "windows", "std.f_nat_hz"),
        (("defects", "--defect", "lateral", "--bearing", "thread", "--dy-mm", "0.1,0.2"), "cases", "f_perp_n"),
    ],
    ids=lambda part: part[0] if isinstance(part, tuple) else None,
)
def test_commands_write_the_rows_of_their_json(tmp_path, command, key, column):
    target = tmp_path / "t.csv"
    done = here(*command, "--csv", target, "--json", tmp_path / "t.json")
    assert done.returncode == 0, done.stderr
    entries = json.loads((tmp_path / "t.json").read_text())[key]
    found = rows_of(target.read_text())
    assert len(found) == len(entries) > 0
    first = entries[0]
    for part in column.split("."):
        first = first[part]
    assert found[0][column] == (first if isinstance(first, str) else json.dumps(first))


def test_a_table_is_never_overwritten_without_force(tmp_path):
    target = tmp_path / "t.csv"
    target.write_text("mine")
    assert_one_line_error(here("design", "--csv", target), 2, "t.csv", "--force")
    assert target.read_text() == "mine"
    assert here("design", "--csv", target, "--force").returncode == 0
    assert rows_of(target.read_text())[0]["step"] == "1"
    assert_one_line_error(here("design", "--csv", tmp_path / "t.txt"), 2, ".csv")


def test_a_dry_run_of_a_series_has_no_table(tmp_path):
    done = here("measure", "--resonator", "jewel", "--dry-run", "--csv", tmp_path / "t.csv")
    assert_one_line_error(done, 2, "--csv", "dry run")


def test_recordings_that_were_found_are_a_table_with_their_frames_by_verdict(tmp_path):
    recordings = tmp_path / "recordings"
    recordings.mkdir()
    write_series(recordings / "a.h5", fits=(fit_table(3),))
    done = here("index", "find", "--recordings", recordings, "--csv", tmp_path / "t.csv")
    assert done.returncode == 0, done.stderr
    (row,) = rows_of((tmp_path / "t.csv").read_text())
    assert (row["id"], row["path"]) == ("a", "a.h5")
    assert int(row["good"]) + int(row["refused"]) == 3
    assert {"sample", "resonator", "f_nat_hz", "m_r_am2"} <= set(row)
