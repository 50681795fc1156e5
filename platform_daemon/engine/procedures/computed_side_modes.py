"""The z channel of a ramp's shots, looked at by whoever computes for the engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon import analysis
from platform_daemon.workers import Computer

from ..computed import computed_surely

if TYPE_CHECKING:
    from platform_daemon.analysis import RecordedSideModes, ZResidual


@dataclass(frozen=True)
class Learn:
    """The noise of blank shots.  A task for whoever computes."""

    blank: Sequence[Path]

    def __call__(self, tell: Callable[[float, str], None]) -> RecordedSideModes:
        """Raises RecordingError."""
        made = analysis.RecordedSideModes()
        made.learn(self.blank)
        return made


@dataclass(frozen=True)
class LookAt:
    """What shots show against that noise.  A task for whoever computes."""

    known: RecordedSideModes
    shots: Sequence[Path]

    def __call__(self, tell: Callable[[float, str], None]) -> list[ZResidual]:
        """Raises RecordingError."""
        return self.known.of(self.shots)


class ComputedSideModes:
    """See SideModes."""

    def __init__(self, computer: Computer) -> None:
        self._computer = computer
        self._known: RecordedSideModes | None = None

    def learn(self, blank: Sequence[Path]) -> None:
        """See SideModes."""
        self._known = computed_surely(self._computer, "procedure", Learn(tuple(blank)))

    def of(self, shots: Sequence[Path]) -> list[ZResidual]:
        """See SideModes.  Raises ValueError before `learn`."""
        if self._known is None:
            raise ValueError("the noise is not known yet")
        return computed_surely(self._computer, "procedure", LookAt(self._known, tuple(shots)))
