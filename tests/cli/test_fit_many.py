"""`platform-daemon fit` of many files: bad ones among them, processes, results kept while it goes on, interrupts."""

import json
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest

from tests.kit.command_line import COMMAND, assert_one_line_error, here, run, wait_for
from tests.kit.data import DATA
from tests.kit.example_copies import copies, links, same
from tests.kit.specimen_files import JEWEL, copied

SHORT = ("--window", "0.1")
MANY = 24  # files: more than are fitted before a signal arrives


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


def test_fit_of_several_files_nests_them(measured):
    done = here("fit", measured / "j.h5", DATA / "example_thread.mmr.h5", "--json", measured / "both.json")
    assert done.returncode == 0, done.stderr
    files = json.loads((measured / "both.json").read_text())["files"]
    assert [f["variant"] for f in files] == ["jewel", "thread"]


@pytest.mark.long
def test_a_batch_interrupted_goes_on_where_it_was(tmp_path):
    paths = links(tmp_path, MANY)
    kept, part, whole = (tmp_path / name for name in ("r.jsonl", "part.json", "all.json"))
    command = [COMMAND, "fit", *paths, *SHORT, "--jsonl", kept, "--json", part, "--processes", "2"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wait_for(lambda: len(lines(kept)) >= 2)
    process.send_signal(signal.SIGINT)
    errors = process.communicate(timeout=30)[1]
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert "resource_tracker" not in errors  # semaphores are given back
    before = lines(kept)
    finished = json.loads(part.read_text())
    ended = [r["file"] for r in finished["files"]]
    assert [str(p) for p in paths if str(p) not in finished["unfinished"]] == ended
    assert len(ended) + len(finished["unfinished"]) == MANY
    assert len(ended) == len(before)
    assert f"{len(before)} of {MANY} files are finished" in errors
    done = run("fit", *paths, *SHORT, "--jsonl", kept, "--resume", "--json", whole)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("finished before") == len(before) < MANY
    assert lines(kept)[: len(before)] == before
    assert len(lines(kept)) == MANY
    assert "unfinished" not in json.loads(whole.read_text())
    reports = json.loads(whole.read_text())["files"]
    assert [r["file"] for r in reports] == [str(p) for p in paths]
    assert all(same(r["frames"], reports[k % 2]["frames"]) for k, r in enumerate(reports))


def test_an_interrupt_before_any_file_has_ended_writes_nothing(tmp_path):
    path = copied(tmp_path, JEWEL)
    with h5py.File(path, "r+") as file:
        volts = np.repeat(file["data"][:], 100, axis=0)  # minutes of fits
        del file["data"]
        file["data"] = volts
    kept, whole = tmp_path / "r.jsonl", tmp_path / "all.json"
    command = [COMMAND, "fit", path, "--jsonl", kept, "--json", whole, "--processes", "2"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wait_for(kept.exists)
    time.sleep(1.0)  # workers start
    process.send_signal(signal.SIGINT)
    errors = process.communicate(timeout=30)[1]
    assert process.returncode == 130
    assert "interrupted" in errors
    assert "resource_tracker" not in errors
    assert (whole.exists(), lines(kept)) == (False, [])


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


@pytest.mark.parametrize("processes", ["1", "2"])
def test_only_the_frames_asked_for_are_fitted_however_the_work_is_split(tmp_path, processes):
    paths = copies(tmp_path, 2)
    for path in paths:
        with h5py.File(path, "r+") as file:
            volts = np.repeat(file["data"][:], 3, axis=0)
            del file["data"]
            file["data"] = volts
    asked = (*SHORT, "--frames", "1,3-5", "--processes", processes, "--json", tmp_path / "r.json")
    done = here("fit", *paths, *asked)
    assert done.returncode == 0, done.stderr
    for report in json.loads((tmp_path / "r.json").read_text())["files"]:
        assert [f["frame"] for f in report["frames"]] == [1, 3, 4, 5]
        assert all(f["verdict"] == "good" for f in report["frames"])
