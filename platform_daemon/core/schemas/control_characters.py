"""Control characters in text, which a terminal would obey: find them, and write them out.

This module imports no pydantic: whatever the command line prints goes through `printable`.
"""

from __future__ import annotations

import re

CONTROL_CHARACTERS = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")
"""Control characters, separators of lines, and what turns the direction of writing."""


_HALVES = re.compile("[\ud800-\udfff]")


def encodable(text: str) -> str:
    """`text` that can be written as UTF-8: bytes of a file name that are not UTF-8 are written out, as \\xfc."""
    return _HALVES.sub(_written_out, text)


def _written_out(found: re.Match[str]) -> str:
    """Python reads such a byte as the half of a pair of surrogates; other halves say nothing."""
    return f"\\x{ord(found[0]) - 0xDC00:02x}" if "\udc80" <= found[0] <= "\udcff" else "\ufffd"


def printable(text: str) -> str:
    """`text` with control characters written out, as \\x1b, but for newline and tab; the rest as `encodable`."""
    text = encodable(text)
    return CONTROL_CHARACTERS.sub(lambda found: found[0] if found[0] in "\n\t" else ascii(found[0])[1:-1], text)
