"""Rules: which events raise an alarm, and which clear it."""

from __future__ import annotations

from collections import deque

from platform_daemon.core.schemas.events import (
    AnyEvent,
    DeviceEvent,
    FitEvent,
    InterlockEvent,
    JobEvent,
    MeasurandEvent,
    ScheduleEvent,
    ShotEvent,
)
from platform_daemon.core.schemas.jobs import JobState

from .board import AlarmBoard

REFUSED_OF_LAST = 3, 10
"""So many of the last so many excited shots, or on-line fits, must be refused."""


class Rules:
    """Sees one event after the other."""

    def __init__(self, board: AlarmBoard) -> None:
        self._board = board
        self._shots: deque[bool] = deque(maxlen=REFUSED_OF_LAST[1])  # refused?
        self._fits: deque[bool] = deque(maxlen=REFUSED_OF_LAST[1])
        self._steps: set[str] = set()  # of procedures, which judge their fits themselves

    def see(self, what: AnyEvent) -> None:
        """Raise or clear what follows from it."""
        match what:
            case ShotEvent() if not what.blank:
                self._shot(what)
            case FitEvent() if what.job not in self._steps:
                self._fit(what)
            case MeasurandEvent():
                self._measurand(what)
            case InterlockEvent():
                self._stands("interlock", None if what.why is None else f"no power may go out: {what.why}")
            case DeviceEvent():
                self._stands(f"device:{what.device}", what.error and f"the {what.device} does not answer: {what.error}")
            case JobEvent() if what.within is not None:
                (self._steps.discard if what.state.final else self._steps.add)(what.job)
            case JobEvent():
                self._job(what)
            case ScheduleEvent():
                self._schedule(what)
            case _:
                pass

    def _stands(self, name: str, what: str | None) -> None:
        if what is None:
            self._board.clear(name)
        else:
            self._board.notice(name, what)

    def _shot(self, shot: ShotEvent) -> None:
        self._shots.append(shot.verdict == "refused")
        refused = sum(self._shots)
        if refused >= REFUSED_OF_LAST[0] and self._shots[-1]:
            what = f"{refused} of the last {len(self._shots)} shots were refused, the last: {shot.reason}"
            self._board.notice("shots", f"{what}. Remedy: find the cause named; the shots are kept, marked refused")
        elif refused == 0:
            self._board.clear("shots")

    def _fit(self, fit: FitEvent) -> None:
        """A rotor that is stuck or out of its clamp leaves good shots with nothing in them."""
        self._fits.append(fit.verdict == "refused")
        refused = sum(self._fits)
        if refused >= REFUSED_OF_LAST[0] and self._fits[-1]:
            what = f"{refused} of the last {len(self._fits)} on-line fits were refused, the last: {fit.reason}"
            self._board.notice("fits", f"{what}. Remedy: look at a shot (platform-daemon plot), and at the resonator")
        elif refused == 0:
            self._board.clear("fits")

    def _measurand(self, told: MeasurandEvent) -> None:
        """Beyond a limit by more than U; it ends once value ± U lies within: noise at a limit changes nothing."""
        name = f"measurand:{told.specimen}"
        if told.within:
            self._board.clear(name)
        elif told.within is False and told.value is not None:
            what = f"{told.name} of {told.specimen} is {told.value:.6g} {told.unit}, U = {told.U:.2g} {told.unit}"
            self._board.notice(name, f"{what}: beyond its limit. Remedy: look at what is measured")
        elif told.within is False:
            what = f"{told.name} of {told.specimen}, which has limits, cannot be read: {told.reason}"
            self._board.notice(name, f"{what}. Remedy: look at what is measured, and at the calibration")

    def _job(self, job: JobEvent) -> None:
        name = f"failed:{job.job_kind}"
        if job.state is JobState.FAILED:
            when = "at its launch" if job.progress.done == 0 else f"after {job.progress.fraction:.0%}"
            self._board.notice(name, f"{job.job} died {when}: {job.error}")
        elif job.state is JobState.DONE:
            self._board.clear(name)

    def _schedule(self, row: ScheduleEvent) -> None:
        name = f"schedule:{row.schedule}"
        if not row.active:  # one by hand, which says nothing of those that are due
            pass
        elif row.state in ("missed", "failed"):
            became = "failed" if row.state == "failed" else "was missed"
            self._board.notice(name, f"the start due at {row.due} {became}: {row.reason}")
        elif row.state in ("run", "late"):
            self._board.clear(name)
        waits = f"mount:{row.schedule}"
        if row.state == "due" and row.reason is not None:
            self._board.notice(waits, row.reason)
        elif row.state in ("due", "started", "missed", "skipped"):  # the others end a row that had begun before
            self._board.clear(waits)
