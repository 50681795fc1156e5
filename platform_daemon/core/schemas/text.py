"""Text that people give: names are one line, comments may be several; neither contains control characters.

Letters that can be written in two ways (an o with diaeresis as one character, or as an o and a combining mark, as some
keyboards and file systems do) are kept in one (Unicode's form NFC), so that what looks alike is alike.
"""

from __future__ import annotations

import unicodedata
from typing import Annotated

from pydantic import AfterValidator, Field

from .control_characters import CONTROL_CHARACTERS

_OF_TEXT = "\n\r\t"


def counted(number: int, noun: str) -> str:
    """As in: 1 shot, 2 shots."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _one_line(text: str) -> str:
    found = CONTROL_CHARACTERS.search(text)
    if found is not None:
        raise ValueError(f"holds the control character {found[0]!a}: it is one line of plain text")
    return unicodedata.normalize("NFC", text)


def _lines(text: str) -> str:
    found = next((each for each in CONTROL_CHARACTERS.findall(text) if each not in _OF_TEXT), None)
    if found is not None:
        raise ValueError(f"holds the control character {found!a}: it is plain text, of several lines perhaps")
    return unicodedata.normalize("NFC", text)


def same_name(text: str) -> str:
    """A name as it is compared: in NFC, without blanks around it, and one blank for several.

    Example:
        >>> same_name(" T  07 ")
        'T 07'
    """
    return " ".join(unicodedata.normalize("NFC", text).split())


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
