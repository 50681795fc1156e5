"""The shots of a series as they come, on the terminal: a line each, and a small curve of their frequency."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from platform_daemon.core.reporting.numbers import estimates_text
from platform_daemon.core.schemas.acquisitions import ShotReport

if TYPE_CHECKING:
    from platform_daemon.core.jobs.jobs import Job

_PAGE, _WIDTH = 1000, 24
_BARS = "▁▂▃▄▅▆▇█"


class ShotLines:
    """Of one job; anything but a series has none."""

    def __init__(self, job: Job) -> None:
        self._job, self._said = job, 0
        self._f_nat_hz: list[float] = []
        self._fits = getattr(job.request, "window", None) is not None

    def new(self) -> Iterator[str]:
        """Lines of shots that were not said yet, in order; one whose fit is still to come, and those after it, wait."""
        while found := self._job.shots.page(self._job.identifier, after=self._said, limit=_PAGE).items:
            for shot in found:
                if self._waits(shot):
                    return
                self._said += 1
                if shot.fit is not None and shot.fit.good:
                    self._f_nat_hz.append(shot.fit.values["f_nat_hz"])
                yield shot_line(shot, int(self._job.total))

    def curve(self) -> str:
        """f_nat of the last good shots between the lowest and the highest of them."""
        last = self._f_nat_hz[-_WIDTH:]
        if len(last) < 2:
            return ""
        low, span = min(last), max(last) - min(last)
        steps = (len(_BARS) - 1) / span if span > 0 else 0.0
        return f"f_nat {''.join(_BARS[round((each - low) * steps)] for each in last)} {span:.3g} Hz"

    def _waits(self, shot: ShotReport) -> bool:
        fitted = self._fits and not shot.blank and shot.verdict == "good"
        return fitted and shot.fit is None and not self._job.ended.is_set()


def shot_line(shot: ShotReport, of: int) -> str:
    """One shot of a series and what its fit says, as: shot 3/20: f_nat 213.1748(7) Hz, χ²/dof 1.004."""
    here = f"shot {shot.shot}/{of}"
    if shot.verdict != "good":
        return f"{here}: refused: {shot.reason}"
    if shot.blank or shot.fit is None:
        return f"{here}: {'blank' if shot.blank else 'not fitted'}"
    if not shot.fit.good:
        return f"{here}: no fit: {shot.fit.reason}"
    known = {name: e for name in ("f_nat_hz", "phi_max_rad") if (e := shot.fit.parameters.get(name)) is not None}
    return f"{here}: {estimates_text(known)}, χ²/dof {shot.fit.chi2_per_dof:.3f}"
