"""`platform-daemon fit` of many files, as a user meets it."""

import json
import signal
import subprocess

import pytest

from tests.batch.files import copies, links, same
from tests.test_cli import COMMAND, assert_one_line_error, here, run, wait_for

SHORT = ("--window", "0.1")


def lines(path):
    return path.read_text().splitlines() if path.exists() else []


def test_a_bad_file_among_others_costs_the_exit_code_only(tmp_path):
    paths = copies(tmp_path, 2)
    bad = tmp_path / "bad.h5"
    bad.write_bytes(b"no hdf5")
    done = run("fit", bad, *paths, *SHORT, "--json", tmp_path / "all.json")
    assert done.returncode == 2
    assert "bad.h5" in done.stderr
    assert "2 of 2 frames good" in done.stdout
    entries = json.loads((tmp_path / "all.json").read_text())["files"]
    assert [("error" in e, e["file"]) for e in entries] == [(True, str(bad)), *((False, str(p)) for p in paths)]
    assert "HDF5" in entries[0]["error"]["detail"]


MANY = 24  # files: more than are fitted before a signal arrives


def test_a_batch_interrupted_goes_on_where_it_was(tmp_path):
    paths = links(tmp_path, MANY)
    kept, whole = tmp_path / "r.jsonl", tmp_path / "all.json"
    command = [COMMAND, "fit", *paths, *SHORT, "--jsonl", kept, "--processes", "2"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wait_for(lambda: len(lines(kept)) >= 2)
    process.send_signal(signal.SIGINT)
    errors = process.communicate(timeout=30)[1]
    assert process.returncode == 130
    assert "Traceback" not in errors
    before = lines(kept)
    assert f"{len(before)} of {MANY} files are finished" in errors
    done = run("fit", *paths, *SHORT, "--jsonl", kept, "--resume", "--json", whole)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("finished before") == len(before) < MANY
    assert lines(kept)[: len(before)] == before
    assert len(lines(kept)) == MANY
    reports = json.loads(whole.read_text())["files"]
    assert [r["file"] for r in reports] == [str(p) for p in paths]
    assert all(same(r["frames"], reports[k % 2]["frames"]) for k, r in enumerate(reports))


def test_a_killed_batch_leaves_no_process_and_only_its_last_line_can_be_cut(tmp_path):
    paths = links(tmp_path, 16)
    kept = tmp_path / "r.jsonl"
    command = [COMMAND, "fit", *paths, *SHORT, "--jsonl", kept, "--processes", "2"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    wait_for(lambda: len(lines(kept)) >= 2)
    process.kill()
    # Standard output is at its end only when all processes that inherited it have ended.
    process.communicate(timeout=30)
    assert all(json.loads(line)["report"]["frames"] for line in lines(kept)[:-1])


def test_results_kept_before_are_not_overwritten_unasked(tmp_path):
    (path,) = copies(tmp_path, 1)
    (tmp_path / "r.jsonl").write_text("something\n")
    assert_one_line_error(here("fit", path, "--jsonl", tmp_path / "r.jsonl"), 2, "r.jsonl", "--force")
    assert_one_line_error(here("fit", path, "--jsonl", tmp_path / "r.jsonl", "--resume"), 2, "line 1")
    assert_one_line_error(here("fit", path, "--resume"), 2, "--jsonl")
    assert (tmp_path / "r.jsonl").read_text() == "something\n"


def test_derived_quantities_are_added_to_the_fixed_form(tmp_path):
    (path,) = copies(tmp_path, 1)
    done = here("fit", path, *SHORT, "--derived", "--json", tmp_path / "d.json")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "d.json").read_text())
    derived = report["frames"][0]["derived"]
    assert derived["equivalent_quality_factor"] < derived["quality_factor"]
    assert derived["equivalent_quality_factor_to_infinity"] == pytest.approx(458, rel=0.2)
    assert len(report["derived"]["orientation_error"]["against_best"]["angle_rad"]) == 2
    assert any("allan" in note for note in report["derived"]["notes"])


def test_slide_draws_flat_lines_and_says_how_flat(tmp_path):
    (path,) = copies(tmp_path, 1)
    done = here("slide", path, "--window", "0.12", "--out", tmp_path / "s.png", "--json", tmp_path / "s.json")
    assert done.returncode == 0, done.stderr
    assert "f_nat_hz" in done.stdout
    assert (tmp_path / "s.png").read_bytes().startswith(b"\x89PNG")
    report = json.loads((tmp_path / "s.json").read_text())
    assert [w["verdict"] for w in report["windows"]] == ["good"] * 8
    assert report["flatness"]["m_r_am2"]["probability"] > 1e-4
    assert_one_line_error(here("slide", path, "--window", "5"), 2, "--window")
    assert_one_line_error(here("slide", path, "--lambda", "loose"), 2, "--lambda")
    assert_one_line_error(here("slide", path, "--frame", "9"), 2, "frame 9")
