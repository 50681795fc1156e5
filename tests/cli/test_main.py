"""The command line as a user meets it: what it says of bad input, and where it can be started."""

import os

import pytest

from tests.kit.command_line import QUICK, assert_one_line_error, here, run


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("fit", "missing.h5"), "missing.h5"),
        (("info", "missing.h5"), "missing.h5"),
        (("plot", "."), "directory"),
        (("measure", "--resonator", "spring", "--out", "x.h5"), "spring"),
        (("measure", *QUICK, "--out", "x.csv"), ".csv"),
        (("fit", "x.h5", "--json", "x.csv"), "end in .json"),
        (("fit", "x.h5", "--jsonl", "x.json"), "end in .jsonl"),
        (("slide", "x.h5", "--out", "x.jpg"), "end in .png"),
        (("predict", "--resonator", "jewel", "--json", "x.csv"), "end in .json"),
        (("measure", *QUICK, "--out", "nowhere/x.h5"), "nowhere"),
        (("measure", *QUICK, "--out", "x.h5", "--field-ut", "5000"), "field"),
        (("measure", *QUICK, "--out", "x.h5", "--window", "d40"), "d40"),
        (("measure", *QUICK, "--out", "x.h5", "--set", "limits.max_field=1"), "max_field"),
        (("measure", "--resonator", "jewel", "--rx-s", "0", "--out", "x.h5"), "rx_s"),
        (("measure", *QUICK, "--out", "x.h5", "--platform", "nothing"), "nothing"),
        (("config", "check", "missing.toml"), "missing.toml"),
        (("fit",), "Missing argument"),
        (("predict", "--resonator", "thread", "--noise", "0,1"), "noise"),
        (("predict", "--resonator", "thread", "--deflection-deg", "95"), "deflection"),
        (("nonsense",), "nonsense"),
        (("measure", *QUICK, "--out", "x.h5", "--shots", "-1"), "--shots"),
        (("measure", *QUICK, "--out", "x.h5", "--shots", "0"), "shots"),
        (("measure", *QUICK, "--out", "x.h5", "--sequence", "missing.toml"), "missing.toml"),
        (("schedule", "add", "x", "--every-s", "9", "--resonator", "jewel", "--rx-s", "5"), "give --work FILE with"),
    ],
)
def test_bad_input_is_one_line_with_exit_code_2_and_leaves_nothing_behind(tmp_path, monkeypatch, arguments, word):
    monkeypatch.chdir(tmp_path)
    assert_one_line_error(here(*arguments), 2, word)
    assert list(tmp_path.iterdir()) == []


def test_the_process_itself_ends_with_exit_code_2(tmp_path):
    assert_one_line_error(run("measure", "--resonator", "spring", "--out", "s.h5", cwd=tmp_path), 2, "spring")


def test_the_package_runs_from_any_folder(tmp_path):
    done = run("--version", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stdout.strip() == "0.1.0"
    assert os.listdir(tmp_path) == []
