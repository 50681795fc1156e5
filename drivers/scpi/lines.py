"""Lines of ASCII."""

from __future__ import annotations

from drivers.errors import DeviceProtocolError


def readable(raw: bytes, where: str) -> str:
    """A line of ASCII.  Raises DeviceProtocolError for an empty one and for garbage."""
    text = raw.decode("ascii", "replace").strip()
    if not text or not text.isprintable() or "\ufffd" in text:
        raise DeviceProtocolError("the answer is garbage", where=where, why=f"it is {raw[:40]!r}")
    return text
