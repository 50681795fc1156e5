"""Which frames of a recording are meant: all, or those that are named."""

from __future__ import annotations

import re
from collections.abc import Sequence

from drivers.errors import InputError
from platform_daemon.store import AngleSeries, Recording

_PART = re.compile(r"(\d{1,9})(?:-(\d{1,9}))?")
_MOST = 1_000_000


def parse_frames(text: str) -> tuple[int, ...]:
    """ "0,2,5-9" as frame numbers, in order, each once.  Raises InputError."""
    found: set[int] = set()
    for part in text.split(","):
        match = _PART.fullmatch(part.strip())
        first, last = (0, -1) if match is None else (int(match[1]), int(match[2] or match[1]))
        if not first <= last < first + _MOST:
            remedy = "write numbers and ranges with commas, as in 0,2,5-9"
            raise InputError(f"no frames {text!r}", where="--frames", remedy=remedy)
        found.update(range(first, last + 1))
    return tuple(sorted(found))


def chosen_frames(recording: Recording | AngleSeries, asked: Sequence[int] | None) -> tuple[int, ...]:
    """The frames asked for, in order, each once; None: all.  Raises InputError for one that does not exist."""
    if asked is None:
        return tuple(range(recording.frames))
    for k in asked:
        if not 0 <= k < recording.frames:
            remedy = f"frames go from 0 to {recording.frames - 1}"
            raise InputError(f"frame {k} does not exist", where=str(recording.path), remedy=remedy)
    return tuple(sorted(set(asked)))
