"""The shots of a series one after the other: what each is to be, and the next drive from the last fit."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future

import structlog

from drivers.errors import SequenceRejected
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.core.schemas.fits import FrameFit
from sequences.compiler import ShotPlan

from .planning import AcquisitionPlan, excited_shot

log = structlog.get_logger()


class ShotsInTurn:
    """What each shot of a plan is played with.

    step: of a procedure, None: the series belongs to none; executor: plans drives.
    """

    def __init__(self, plan: AcquisitionPlan, step: StepLabel | None, executor: TaskExecutor) -> None:
        self._plan, self._step, self._executor = plan, step, executor
        self.waits_for_fits = plan.sequence.phase_plan == "last_fit"
        self.warnings: list[str] = []

    def label(self, shot: int) -> StepLabel | None:
        """Label of the shot of this number, from 0: the values changed for it, and those of its step."""
        changes = self._plan.changes_of(shot)
        if changes is None:
            return self._step
        values = {k: v if isinstance(v, int | float | str) else ",".join(f"{x:g}" for x in v) for k, v in changes}
        if self._step is None:
            return StepLabel(shot + 1, values)
        return StepLabel(self._step.number, {**self._step.values, **values}, self._step.name)

    def shot(self, number: int, fits: Sequence[Future[FrameFit] | str]) -> ShotPlan:
        """The shot of this number, from 0; fits: of those before, of which the last good one is waited for.

        Without one the drive follows what was known before the series.  A drive that cannot be planned with the fitted
        values is played as before, with a warning.
        """
        planned = self._plan.shots[number]
        if planned.blank or not self.waits_for_fits:
            return planned
        fitted = _last_good(fits)
        if fitted is None:
            return planned
        plan = self._plan
        try:
            shot, _ = excited_shot(planned.request, plan.side, plan.specimen, plan.model, self._executor, fitted)
        except SequenceRejected as error:
            self.warnings.append(f"shot {number + 1} is not driven by the last fit: {error}")
            return planned
        log.info("drive_planned", shot=number + 1, f_nat_hz=fitted["f_nat_hz"], mean_hz=shot.frequency_hz)
        return shot


def _last_good(fits: Sequence[Future[FrameFit] | str]) -> dict[str, float] | None:
    """Parameters of the last good fit by public name; None: there is none."""
    for fit in reversed(fits):
        if not isinstance(fit, str) and fit.exception() is None and fit.result().good:
            return {name: estimate.value for name, estimate in fit.result().parameters.items()}
    return None
