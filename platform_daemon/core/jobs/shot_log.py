"""The shots of one job as they come: each once it is on disk, then its fit."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from platform_daemon.core.schemas.acquisitions import ShotPage, ShotReport
from platform_daemon.core.schemas.fits import FrameFit


class ShotLog:
    """Written by the thread of the series and that of the fits, read by anybody."""

    def __init__(self) -> None:
        self._shots: list[ShotReport] = []  # in order, from number 1
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._shots)

    def stored(self, shot: ShotReport) -> None:
        """The next shot is on disk."""
        with self._lock:
            assert shot.shot == len(self._shots) + 1
            self._shots.append(shot)

    def taken_up(self, shots: Sequence[ShotReport]) -> None:
        """Add the shots that are on disk already, in one step, so that no reader sees fewer than there are."""
        with self._lock:
            assert not self._shots
            self._shots = list(shots)

    def fitted(self, number: int, fit: FrameFit) -> ShotReport:
        """The fit of a shot on disk, from 1; the shot with it."""
        with self._lock:
            shot = self._shots[number - 1]  # of a step: its frame in the recording of the procedure
            numbered = fit.model_copy(update={"frame": shot.frame})
            found = self._shots[number - 1] = shot.model_copy(update={"fit": numbered})
            return found

    def page(self, series: str, *, after: int, limit: int) -> ShotPage:
        """Shots with larger numbers than `after`; series: id of the job."""
        with self._lock:
            return ShotPage.cut(self._shots, series, after=after, limit=limit)
