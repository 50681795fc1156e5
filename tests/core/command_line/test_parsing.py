"""Texts of the command line as values."""

from __future__ import annotations

import pytest

from drivers.errors import InputError
from platform_daemon.core.command_line.parsing import parse_window


@pytest.mark.parametrize(("text", "window"), [("n50", "n50"), ("N50", "n50"), ("D30", "d30"), ("0.5", 0.5)])
def test_a_window_may_be_written_as_tables_name_it(text: str, window: object) -> None:
    assert parse_window(text) == window


@pytest.mark.parametrize("text", ["d40", "0", "-1", "nan", "inf", ""])
def test_what_is_no_window_is_refused_with_those_there_are(text: str) -> None:
    with pytest.raises(InputError, match="give n50, d30, or a positive number of seconds"):
        parse_window(text)
