"""Text that people give: names are one line, comments may be several; neither holds what a terminal would obey."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field

_OBEYED = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")
"""Control characters, separators of lines, and what turns the direction of writing."""
_OF_TEXT = "\n\r\t"


def printable(text: str) -> str:
    """`text` with control characters written out, as \\x1b, but for newline and tab."""
    return _OBEYED.sub(lambda found: found[0] if found[0] in "\n\t" else _written_out(found[0]), text)


def _written_out(character: str) -> str:
    return ascii(character)[1:-1]


def _one_line(text: str) -> str:
    found = _OBEYED.search(text)
    if found is not None:
        raise ValueError(f"holds the control character {found[0]!a}: it is one line of plain text")
    return text


def _lines(text: str) -> str:
    found = next((each for each in _OBEYED.findall(text) if each not in _OF_TEXT), None)
    if found is not None:
        raise ValueError(f"holds the control character {found!a}: it is plain text, of several lines perhaps")
    return text


OneLine = AfterValidator(_one_line)
"""For a field: text without control characters."""
Name = Annotated[str, Field(min_length=1, max_length=200), OneLine]
"""Of a person, or of what people call by one."""
Line = Annotated[str, Field(max_length=2000), OneLine]
"""One line, which may be empty."""
SeveralLines = AfterValidator(_lines)
"""For a field: the same, but for newlines and tabs."""
Text = Annotated[str, Field(max_length=2000), SeveralLines]
"""A comment, which may have several lines."""
