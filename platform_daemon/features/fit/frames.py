"""Which frames of a file are meant: all, or those that are named."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from drivers.errors import InputError


class _Frames(Protocol):
    @property
    def path(self) -> Path:
        """What errors name."""

    @property
    def frames(self) -> int:
        """How many frames there are."""


def chosen_frames(file: _Frames, requested: Sequence[int] | None) -> tuple[int, ...]:
    """The requested frames, in order, each once; None: all.  Raises InputError for one that does not exist."""
    if requested is None:
        return tuple(range(file.frames))
    for k in requested:
        if not 0 <= k < file.frames:
            remedy = f"frames go from 0 to {file.frames - 1}"
            raise InputError(f"frame {k} does not exist", where=str(file.path), remedy=remedy)
    return tuple(sorted(set(requested)))
