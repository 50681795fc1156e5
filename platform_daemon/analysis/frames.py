"""Which frames of a recording are meant: all, or those that are named."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.errors import InputError
from platform_daemon.store import AngleSeries, Recording


def chosen_frames(recording: Recording | AngleSeries, asked: Sequence[int] | None) -> tuple[int, ...]:
    """The frames asked for, in order, each once; None: all.  Raises InputError for one that does not exist."""
    if asked is None:
        return tuple(range(recording.frames))
    for k in asked:
        if not 0 <= k < recording.frames:
            remedy = f"frames go from 0 to {recording.frames - 1}"
            raise InputError(f"frame {k} does not exist", where=str(recording.path), remedy=remedy)
    return tuple(sorted(set(asked)))
