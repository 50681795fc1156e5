"""docs/howto/mistakes.md: each command of its first tables is run, and says what the page says."""

import json
import re
import shlex
import shutil
from pathlib import Path

import h5py
import pytest

from platform_daemon.core.recordings.series_writer import SeriesWriter
from tests.kit.command_line import QUICK, assert_one_line_error, here
from tests.kit.data import DATA
from tests.kit.pages import ROOT
from tests.kit.recording_files import MINIMAL, NO_FILTER, header, packed_by, shot, write_minimal

PAGE = (ROOT / "docs/howto/mistakes.md").read_text()
ROW = re.compile(r"^\| [^|]+ \| `([^|`]+)` \| ([^|]+) \|$", re.MULTILINE)
MISTAKES = ROW.findall(PAGE.partition("## When the shots")[0])


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A recording of one shot, a series that was killed after its first shot, a TOML file."""
    made = tmp_path_factory.mktemp("mistakes")
    with SeriesWriter.create(made / "a.h5", header(planned_shots=1)) as writer:
        writer.add_shot(shot(1))
        writer.finish(())
    with SeriesWriter.create(made / "killed.h5", header()) as writer:
        writer.add_shot(shot(1))
    (made / "other.toml").write_text("a = 1\n")
    write_minimal(made / "packed.h5", {"/data": packed_by(NO_FILTER, MINIMAL["/data"])})
    (made / "twice.csv").write_text("time_s,x_v,x_v\n0,1,0\n1,2,0\n")
    return made


@pytest.fixture
def folder(files, tmp_path, monkeypatch):
    """A copy of them, which is the current folder."""
    monkeypatch.chdir(tmp_path)
    return shutil.copytree(files, tmp_path, dirs_exist_ok=True)


def test_the_page_has_its_mistakes():
    assert len(MISTAKES) > 50


@pytest.mark.parametrize(("command", "said"), MISTAKES)
def test_a_mistake_is_answered_as_the_page_says(folder, command, said):
    words = shlex.split(command.replace("…", "measure --resonator jewel"))
    assert_one_line_error(here(*words), 2, said)


def test_the_next_measure_says_what_it_has_put_together(folder):
    done = here("measure", *QUICK, "--window", "n50", "--out", "b.h5")
    assert done.returncode == 0, done.stderr
    assert "recovered: killed.h5" in done.stderr
    assert here("info", "killed.h5").returncode == 0


@pytest.mark.parametrize(
    "words",
    [("characterise", "--shots", 2), ("ramp",), ("tune",), ("sweep", "--over", "field_ut=200,300"), ("measure",)],
    ids=lambda words: words[0],
)
def test_every_command_that_measures_says_what_it_has_put_together(folder, words):
    done = here(*words, "--resonator", "jewel", "--out", "a.h5")  # a.h5 exists: nothing is measured
    assert done.returncode == 2
    assert "\nrecovered: killed.h5: put together from the shots of a series" in f"\n{done.stderr}"
    assert "a.h5: exists already" in done.stderr.splitlines()[-1]


def test_a_killed_series_of_the_same_name_is_not_overwritten_by_force(folder):
    done = here("measure", *QUICK, "--window", "n50", "--out", "killed.h5", "--force")
    assert done.returncode == 0, done.stderr
    assert "recovered: killed.recovered.h5" in done.stderr


@pytest.mark.parametrize("command", ["fit", "info", "plot", "harmonics", "slide", "diagnose"])
def test_every_command_names_a_layout_of_another_version(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "example_jewel.mmr.h5", "a.h5")
    with h5py.File("a.h5", "a") as h5:
        h5.attrs["recording_layout"] = "platform-daemon/2"
    done = here(command, "a.h5")
    said = done.stdout + done.stderr
    for words in ("another version", "platform-daemon/2", "platform-daemon/1"):
        assert words in " ".join(said.split()), said


def test_config_check_takes_the_sequences_that_measure_takes(tmp_path):
    (tmp_path / "s.toml").write_text("field_t = 310e-6\n")
    done = here("config", "check", tmp_path / "s.toml")
    assert done.returncode == 0, done.stderr
    (tmp_path / "s.toml").write_text("field_t = 310e-6\nrx_ss = 1.0\n")
    assert_one_line_error(here("config", "check", tmp_path / "s.toml"), 2, "rx_ss")


def test_blank_shots_are_counted_apart_from_refused_ones(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = here("measure", *QUICK, "--window", "n50", "--blank-shots", 2, "--out", "b.h5")
    assert done.returncode == 0, done.stderr
    assert "frame 0-1: a blank shot, without excitation" in done.stdout
    assert "refused" not in done.stdout
    assert "3, of which 1 good and 2 blank" in here("info", "b.h5").stdout
    only = here("fit", "b.h5", "--frames", "0,1", "--json", "only.json")
    assert (only.returncode, only.stderr.strip()) == (
        3,
        "no frame was excited: frame 0: a blank shot, without excitation",
    )
    assert [f["verdict"] for f in json.loads(Path("only.json").read_text())["frames"]] == ["blank", "blank"]
