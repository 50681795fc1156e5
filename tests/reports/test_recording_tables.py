"""What `info` prints: tables no wider than the terminal, and only what the file says."""

import pytest

from platform_daemon.reports.recording_tables import print_recording
from platform_daemon.store.description import describe
from platform_daemon.store.reader import open_recording
from tests.kit.data import DATA


def printed(path, capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    print_recording(describe(open_recording(path)))
    return capsys.readouterr().out


@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize("name", ["example_jewel.mmr.h5", "example_thread.mmr.h5"])
def test_no_line_is_wider_than_the_terminal_and_nothing_unsaid_is_printed(name, columns, capsys, monkeypatch):
    text = printed(DATA / name, capsys, monkeypatch, columns)
    assert max(map(len, text.splitlines())) <= columns
    assert "None" not in text
    assert "operator" not in text
