"""Text files that people write: UTF-8, with the byte order mark that editors on Windows put before it."""

from __future__ import annotations

import codecs
from pathlib import Path

_OTHERS = (  # a mark before those that it begins with
    (codecs.BOM_UTF32_LE, "UTF-32"),
    (codecs.BOM_UTF32_BE, "UTF-32"),
    (codecs.BOM_UTF16_LE, "UTF-16"),
    (codecs.BOM_UTF16_BE, "UTF-16"),
)


def read_text_file(path: Path) -> str:
    """The text of a file in UTF-8, without a byte order mark, each line ended by a newline alone.

    Raises OSError; ValueError naming the encoding if it is another one.
    """
    raw = path.read_bytes()
    other = next((name for mark, name in _OTHERS if raw.startswith(mark)), "UTF-16" if b"\0" in raw[:2] else None)
    if other is not None:
        raise ValueError(f"the file is in {other}: save it as UTF-8")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"byte {error.start} is not UTF-8: save the file as UTF-8") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")
