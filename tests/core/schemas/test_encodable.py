"""Names of files that are not UTF-8, wherever they are shown or sent."""

from __future__ import annotations

import json
import os

import pytest

from platform_daemon.core.reporting.figures import new_figure, png_of
from platform_daemon.core.reporting.tables import tables_text
from platform_daemon.core.schemas.base import Root, to_json
from platform_daemon.core.schemas.control_characters import encodable, printable

NAME = os.fsdecode(b"pr\xfcfling.h5")


def test_bytes_that_are_not_utf_8_are_written_out() -> None:
    """Case 10: names that are not UTF-8."""
    assert encodable(NAME) == printable(NAME) == r"pr\xfcfling.h5"
    assert encodable("half \ud834 of two") == "half \ufffd of two"
    assert encodable("whole 𝄞, Łódź") == "whole 𝄞, Łódź"


@pytest.mark.parametrize("text", ["𝄞", r"\ud800", "\\" + "\udcfc", "a\ud834", "\udcfc\udcfc", "\n\"'"])
def test_json_is_text_in_utf_8_and_says_the_same(text: str) -> None:
    found = json.loads(to_json(Root[str](text)))
    assert found.encode() == encodable(text).encode()


def test_titles_of_figures_and_tables_take_them() -> None:
    figure = new_figure(2, 2)
    figure.suptitle(NAME)
    figure.subplots().set_title(NAME)
    assert png_of(figure, 30).startswith(b"\x89PNG")
    printable(tables_text(NAME, ("a", [NAME]), [("b", ["1"])])).encode()
