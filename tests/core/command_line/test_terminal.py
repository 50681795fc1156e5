"""What is printed reaches the terminal as text, whatever names hold."""

import io
import sys

import pytest
from rich.console import Console

from platform_daemon.core.command_line.terminal import for_rich, plain_text_only
from tests.kit.command_line import here
from tests.kit.recording_files import write_series
from tests.kit.specimen_months import months

CLEARS = "\x1b[2J\x9b31m\x07 \u202e[/bold]"
OBEYED = ("\x1b", "\x9b", "\x07", "\u202e", "\x08")


def test_names_in_files_are_printed_with_their_control_characters_written_out(tmp_path):
    path = write_series(
        tmp_path / "a.h5", sample_name=CLEARS, operator=CLEARS, comment=f"{CLEARS}\nsecond", title=CLEARS
    )
    told = here("info", path)
    assert told.returncode == 0, told.stderr
    assert "\\x1b[2J\\x9b31m\\x07 \\u202e[/bold]" in told.stdout.replace("\n", "")
    assert not any(each in told.stdout for each in OBEYED)


def test_specimens_and_errors_are_too(tmp_path):
    months(tmp_path, 1, specimen=f"T{CLEARS}")
    for arguments in (
        ("trend", f"T{CLEARS}"),
        ("trend", CLEARS),
        ("retention", "--older-than-days", "1", "--keep-newest", "0"),
    ):
        told = here(*arguments, "--recordings", tmp_path)
        assert "\\x1b[2J" in told.stdout + told.stderr
        assert not any(each in told.stdout + told.stderr for each in OBEYED)


def test_rich_writes_to_the_terminal_itself_and_nothing_is_left_behind(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stdout", stream)
    with plain_text_only(), plain_text_only():
        print("a\x1b[2Jb\tc")
        Console(force_terminal=True).print("[bold]d")
        assert for_rich(sys.stdout) is stream
    assert sys.stdout is stream
    assert stream.getvalue().startswith("a\\x1b[2Jb\tc\n\x1b[1md")


@pytest.mark.parametrize("option", ["--sample", "--operator", "--comment"])
def test_a_series_does_not_take_them(tmp_path, option):
    told = here("measure", "--resonator", "jewel", "--dry-run", option, "a\x1b[2J", "--out", tmp_path / "a.h5")
    assert told.returncode == 2
    assert f"{option.removeprefix('--')!r} is wrong: holds the control character '\\x1b'" in told.stderr
