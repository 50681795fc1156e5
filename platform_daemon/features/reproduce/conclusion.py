"""What is made of a campaign's recordings: the noise sweep, the claims, and the folder's report."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.command_line.output import write_json
from platform_daemon.features.characterise.schema import CharacterisationReport
from platform_daemon.features.characterise.side_by_side.noise_schema import NoiseSweepReport
from platform_daemon.features.characterise.side_by_side.sweep import (
    HIGHEST_AM2_PER_S,
    PARTS,
    NoiseOptions,
    sweep_of,
    swept,
)
from platform_daemon.features.characterise.tables import CharacterisationTask, characterisation_task
from platform_daemon.features.fit.batch.executors import WorkerPool
from platform_daemon.features.fit.fit_request import FitSettings

from .campaign import outcome_in
from .claims import claims_of
from .findings import Findings
from .folder import write_claims
from .schema import Claims


def conclude(
    folder: Path, draws: int, workers: AbstractContextManager[WorkerPool], tell: Callable[[str, float], None]
) -> Claims:
    """Add noise to the shots of both, and write claims and report.  What a sweep has made before stays.

    Raises PlatformError; what `tell` raises.
    """
    outcomes = {v: found for v in ("thread", "jewel") if (found := outcome_in(folder, v)) is not None}
    reports = {variant: found.report for variant, found in outcomes.items()}
    tasks = {variant: _task(folder / f"{variant}.h5", report) for variant, report in reports.items()}
    noise, why = _swept(folder, tasks, reports, NoiseOptions(None, HIGHEST_AM2_PER_S, draws), workers, tell)
    claims = claims_of(Findings(outcomes, noise, why))
    tell("report", 1.0)
    write_claims(folder, claims, tasks, reports, noise)
    return claims


def _task(recording: Path, report: CharacterisationReport) -> CharacterisationTask:
    """Of the shots that were reported on.  Raises InputError, RecordingError."""

    frames = tuple(fit.frame for fit in report.d30_fits.frames)
    return characterisation_task(recording, FitSettings(frames=frames), report.n50.held, report.alpha)


def _swept(
    folder: Path,
    tasks: Mapping[str, CharacterisationTask],
    reports: Mapping[str, CharacterisationReport],
    options: NoiseOptions,
    workers: AbstractContextManager[WorkerPool],
    tell: Callable[[str, float], None],
) -> tuple[NoiseSweepReport | None, str]:
    """The sweep, or why there is none.  Raises PlatformError; what `tell` raises."""
    if len(tasks) < 2:
        return None, "only one of the resonators was measured in this campaign"
    try:
        made = sweep_of(list(tasks.values()), list(reports.values()), options)
    except InputError as error:  # no calibration, or no shot with a fit: the campaign has the rest of its numbers
        return None, str(error)
    found = swept(folder / PARTS, made, list(reports.values()), options, workers, tell)
    write_json(folder / "noise.json", found)
    return found, ""
