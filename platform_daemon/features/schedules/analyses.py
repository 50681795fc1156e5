"""Fits and diagnoses that are due: their records are written here, and queued by the process that runs analyses.

The record of a job that waits is the message: it survives both processes, and neither has to run at that moment.
"""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from drivers.errors import DeviceStateError, InputError
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.jobs import AnyJob, Job
from platform_daemon.core.recordings.recording_index import open_index
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.schemas.text import same_name
from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.state.errors import StorageError
from platform_daemon.features.diagnose.request_schema import DiagnosisRequest
from platform_daemon.features.fit.request_schema import RecordingFitRequest

from .schema import DiagnosisWorkRequest, FitWorkRequest


class ScheduledAnalyses:
    """records: of all jobs; recordings: their folder, with its index."""

    KINDS = frozenset({"fit", "diagnosis"})

    def __init__(self, records: JobRecords, recordings: Path) -> None:
        self._records, self._recordings = records, recordings

    def waits_for(self) -> str | None:
        """What must be there before one can begin; None: nothing is missing."""
        try:
            with closing(open_index(self._recordings)) as index:
                return None if index.finished else "the index of the recordings is being made"
        except StorageError:  # its start reports it
            return None

    def queue(self, work: FitWorkRequest | DiagnosisWorkRequest, identifier: str) -> None:
        """A job that waits.  Raises DeviceStateError if no recording is of its specimen yet, IndexUnfinished,
        StorageError.
        """
        newest = work.newest if isinstance(work, DiagnosisWorkRequest) else 1
        names = self._newest(work.specimen, newest)
        job: AnyJob
        if isinstance(work, FitWorkRequest):
            fit = RecordingFitRequest(recording=names[0], variant=work.variant, terms=work.terms, window=work.window)
            job = Job("fit", fit, NoResult(), 1, "frames", identifier=identifier)
        else:
            diagnosis = DiagnosisRequest(recordings=[*names], variant=work.variant, base=work.base)
            job = Job("diagnosis", diagnosis, NoResult(), 1.0, "share", identifier=identifier)
        self._records.save(job)

    def shown(self, identifier: str) -> JobView:
        """As it was last saved.  Raises InputError if its record cannot be read, StorageError."""
        try:
            return JobView.of(self._records.one(identifier))
        except ValueError as error:
            remedy = "the log says more; the schedule goes on"
            raise InputError(
                "the record of the job cannot be read", where=identifier, why=str(error), remedy=remedy
            ) from None

    def _newest(self, specimen: str, count: int) -> list[str]:
        """Ids of its recordings, newest last."""
        with closing(open_index(self._recordings)) as index:
            found = list(index.newest(same_name(specimen), count))
        if not found:
            why = "none with on-line fits has been indexed"
            remedy = "measure it first; `sample` of an acquisition is the name of the specimen, else its resonator's"
            raise DeviceStateError(f"no recording is of {specimen!r}", where="work.specimen", why=why, remedy=remedy)
        return found
