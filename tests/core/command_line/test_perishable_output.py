"""The durable result comes first: what becomes of the terminal decides neither over files nor over exit codes."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys

import pytest

from platform_daemon.core.command_line.terminal import TolerantStream, print_kept_nowhere, tolerant_streams
from tests.kit.command_line import COMMAND, assert_one_line_error, here
from tests.kit.recording_files import write_series
from tests.kit.small_disk import remount, small_disk


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_series(tmp_path_factory.mktemp("series") / "a.h5", sample_name="10 µm Draht")


def as_process(arguments, stdout, **environment):
    return subprocess.run(
        [COMMAND, *map(str, arguments)],
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
        timeout=120,
        env=os.environ | environment,
        check=False,
    )


def test_a_full_disk_under_a_log_costs_lines_of_the_log_and_says_so(recording, tmp_path):
    """Case 04: the file is written before the table is printed."""
    with open("/dev/full", "w") as full:
        done = as_process(("info", recording, "--json", tmp_path / "r.json"), full)
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "r.json").read_text())
    assert "not all of the output was written: No space left on device" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_folder_that_cannot_be_written_is_told_before_the_work(recording, tmp_path):
    """Case 11: a disk that is read-only."""
    with small_disk(tmp_path / "disk", 1) as disk:
        remount(disk, "ro")
        for words in (("fit", recording), ("diagnose", recording), ("predict", "--resonator", "jewel")):
            done = here(*words, "--json", disk / "x.json")
            assert_one_line_error(done, 2, "x.json: its folder cannot be written", "Remedy: name a file in another")
            assert done.stdout == ""


def test_a_reader_that_has_ended_costs_nothing_else(recording, tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = as_process(("info", recording, "--json", tmp_path / "r.json"), writer)
    finally:
        os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads((tmp_path / "r.json").read_text())


def test_characters_that_a_terminal_does_not_have_are_replaced(recording, tmp_path):
    with (tmp_path / "out").open("w") as out:
        done = as_process(
            ("info", recording, "--json", tmp_path / "r.json"), out, PYTHONIOENCODING="ascii", PYTHONUTF8="0"
        )
    assert (done.returncode, done.stderr) == (0, "")
    assert b"10 ?m Draht" in (tmp_path / "out").read_bytes()
    assert json.loads((tmp_path / "r.json").read_text())


@pytest.mark.parametrize("code", [0, 1, 3, 130])
def test_no_exit_code_depends_on_the_terminal(code):
    program = (
        "import sys\nfrom platform_daemon.core.command_line.terminal import plain_text_only, tolerant_streams\n"
        f"with tolerant_streams(), plain_text_only():\n    print('x' * 100000); sys.exit({code})\n"
    )
    with open("/dev/full", "w") as full:
        done = subprocess.run([sys.executable, "-c", program], stdout=full, stderr=full, timeout=60, check=False)
    assert done.returncode == code


def test_a_token_that_nobody_can_read_is_a_failure(tmp_path):
    with open("/dev/full", "w") as full:
        done = as_process(("token", "add", "anna", "--role", "viewer", "--data", tmp_path), full)
    assert done.returncode == 1
    assert "standard output: No space left on device" in done.stderr


class Encoded(io.TextIOWrapper):
    def __init__(self, encoding):
        self.bytes = io.BytesIO()
        super().__init__(self.bytes, encoding=encoding, write_through=True)


@pytest.mark.parametrize(
    ("encoding", "shown"), [("latin-1", b"\xb5 ? ?"), ("cp1252", b"\xb5 \x97 ?"), ("ascii", b"? ? ?")]
)
def test_only_what_an_encoding_lacks_is_replaced(encoding, shown):
    stream = Encoded(encoding)
    TolerantStream(stream).write("µ — ─")
    assert stream.bytes.getvalue() == shown


def test_streams_are_what_they_were_afterwards(monkeypatch):
    out = io.StringIO()
    monkeypatch.setattr(sys, "stdout", out)
    with tolerant_streams():
        print("a")
        print_kept_nowhere("b")
    assert sys.stdout is out
    assert out.getvalue() == "a\nb\n"
