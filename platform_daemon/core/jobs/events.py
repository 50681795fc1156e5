"""What the engine tells while it works, as events."""

from __future__ import annotations

from collections.abc import Callable

from platform_daemon.core.schemas.acquisitions import ShotReport
from platform_daemon.core.schemas.events import AnyEvent, FitEvent, JobEvent, ShotEvent
from platform_daemon.core.schemas.fits import FrameFit

from .jobs import AnyJob

EventSink = Callable[[AnyEvent], None]
"""Takes an event; never waits, never raises."""


def null_sink(what: AnyEvent) -> None:
    """Discard an event."""


def job_event(job: AnyJob) -> JobEvent:
    """A job as it is now."""
    return JobEvent(
        job=job.identifier,
        job_kind=job.kind,
        state=job.state,
        progress=job.progress(),
        within=job.within,
        recording=getattr(job.result, "recording", None),
        error=None if job.error is None else str(job.error),
    )


def shot_event(job: AnyJob, recording: str, shot: ShotReport) -> ShotEvent:
    """A shot of a series is on disk."""
    return ShotEvent(
        job=job.identifier,
        shot=shot.shot,
        of=int(job.total),
        recording=recording,
        frame=shot.frame,
        blank=shot.blank,
        verdict=shot.verdict,
        reason=shot.reason,
    )


def fit_event(
    job: AnyJob, shot: int, fit: FrameFit, specimen: str | None = None, temperature_c: float | None = None
) -> FitEvent:
    """The fit of a shot of a series; specimen: name of the resonator; temperature_c: None: not known."""
    f_nat, phi_max = fit.parameters.get("f_nat_hz"), fit.parameters.get("phi_max_rad")
    return FitEvent(
        job=job.identifier,
        shot=shot,
        verdict=fit.verdict,
        reason=fit.reason,
        f_nat_hz=None if f_nat is None else f_nat.value,
        f_nat_std_hz=None if f_nat is None else f_nat.std,
        phi_max_rad=None if phi_max is None else phi_max.value,
        nrmse=fit.nrmse,
        chi2_per_dof=fit.chi2_per_dof,
        whiteness=None if fit.whiteness_by_channel is None else min(fit.whiteness_by_channel),
        warnings=fit.warnings,
        seconds=fit.seconds,
        specimen=specimen,
        temperature_c=temperature_c,
    )
