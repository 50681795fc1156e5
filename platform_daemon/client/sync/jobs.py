"""Jobs: how far they are, what comes out, and what can be done with them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar, cast

from drivers.errors import InputError
from platform_daemon.client.answers import value_of
from platform_daemon.client.display import Display, asks_to_stop, display_of
from platform_daemon.client.errors import JobCancelled, JobEnded, JobFailed, WaitTimeout
from platform_daemon.client.requests import request_from
from platform_daemon.client.tables import steps_table
from platform_daemon.core.jobs.kinds import job_type
from platform_daemon.core.registry import feature_of
from platform_daemon.core.reporting.dataframes import fits_table
from platform_daemon.core.schemas.acquisitions import AcquisitionResult, ShotReport
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.schemas.calibrations import CalibrationReport
from platform_daemon.core.schemas.derived import DerivedReport, EnvelopesReport
from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.core.schemas.jobs import Job as JobModel
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.diagnosis.report_schema import DiagnosisReport
from platform_daemon.features.budget.schema import BudgetReport
from platform_daemon.features.characterise.schema import CharacterisationReport
from platform_daemon.features.diagnose.request_schema import AdoptionRequest
from platform_daemon.features.models.schema import AdoptedModelRecord
from platform_daemon.features.procedures.schema import ProcedureResult
from platform_daemon.features.reproduce.schema import Claims
from platform_daemon.features.self_test.schema import SelfTestReport

from .recordings import Recording
from .transport import Transport

if TYPE_CHECKING:
    import pandas as pd

ResultT = TypeVar("ResultT")
_FIRST_POLL_S, _LONGEST_POLL_S = 0.05, 1.0


class Job(Generic[ResultT]):
    """A job of the daemon, as it was seen last: `refresh` and `wait` look at it again.

    Attributes:
        view: the job with request, progress and result, as `GET` of its path answers.
    """

    def __init__(self, transport: Transport, view: JobModel[Any, Any]) -> None:
        self._transport, self.view = transport, view

    @property
    def id(self) -> str:
        """Id of the job."""
        return self.view.id

    @property
    def kind(self) -> str:
        """Kind of the job."""
        return self.view.kind

    @property
    def state(self) -> JobState:
        """queued, running, done, failed or cancelled."""
        return self.view.state

    @property
    def result(self) -> ResultT:
        """What came out so far.  Raises JobEnded if there is no result."""
        if isinstance(self.view.result, NoResult):
            why = f"it is {self.state}"
            raise JobEnded(self.id, "the job has no result", why=why, remedy="wait for its end; see `view.error`")
        return cast(ResultT, self.view.result)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id}: {self.state}, {100 * self.view.progress.fraction:.0f} %>"

    def refresh(self) -> JobModel[Any, Any]:
        """The job as it is now.  Raises NotFound if the daemon does not know it."""
        operation = f"get_{self.kind}"
        self.view = self._transport.get(job_type(self.kind), operation, identifier=self.id)
        return self.view

    def cancel(self) -> JobModel[Any, Any]:
        """Cancel it; outputs are off within 0.1 s, and what was measured stays."""
        return self._send(f"cancel_{self.kind}")

    def wait(self, *, progress: bool = False, timeout_s: float | None = None) -> Self:
        """Wait until it has ended; the job itself.

        progress: show a bar, in a notebook with the last fit; Ctrl-C then asks whether the job is to be stopped or left
        running.  timeout_s: at most so long, s; None: as long as it takes.
        Raises JobFailed, JobCancelled, WaitTimeout.
        """
        shown = display_of(self.id, shows=progress)
        try:
            self._wait(shown, timeout_s)
        except KeyboardInterrupt:
            if asks_to_stop(self.id):
                self.cancel()
            raise
        finally:
            shown.close()
        return self

    def _wait(self, shown: Display, timeout_s: float | None) -> None:
        until_s = None if timeout_s is None else time.monotonic() + timeout_s
        pause_s = _FIRST_POLL_S
        while True:
            view = self.refresh()
            shown.at(view)
            if view.state.final:
                break
            if until_s is not None and time.monotonic() > until_s:
                what = f"the job has not ended within {timeout_s:g} s"
                remedy = "wait again, or cancel it"
                raise WaitTimeout(what, where=self.id, why=f"it is {view.state}", remedy=remedy)
            time.sleep(pause_s)
            pause_s = min(1.5 * pause_s, _LONGEST_POLL_S)
        if view.state is JobState.FAILED:
            problem = view.error
            why = "" if problem is None else problem.detail or problem.title
            raise JobFailed(self.id, f"the {self.kind} failed", why=why, remedy="remove the cause and start a new job")
        if view.state is JobState.CANCELLED:
            raise JobCancelled(self.id, f"the {self.kind} was cancelled", remedy="start a new job")

    def _send(self, operation: str, content: str | None = None) -> JobModel[Any, Any]:
        response = self._transport.send(operation, content=content, identifier=self.id)
        self.view = value_of(response, job_type(self.kind))
        return self.view

    def _page(self, operation: str, path: str | Path | None) -> str:
        text = (self._transport.send(operation, identifier=self.id)).text
        if path is not None:
            Path(path).write_text(text, encoding="utf-8")
        return text


class QueuedJob(Job[ResultT]):
    """A job that waits for the platform, if others are there before it."""

    def edit(self, **values: Any) -> JobModel[Any, Any]:
        """Other values for some keys of its request, as long as it waits.  Raises Conflict once it has begun."""
        model = type(self.view.request)
        changed = request_from(model, values, "edit", base=self.view.request)
        return self._send(f"edit_{self.kind}", changed.model_dump_json())


class _MakesRecording(QueuedJob[ResultT]):
    def recording(self) -> Recording:
        """Its recording.  Raises JobEnded if there is none, or none yet."""
        identifier = getattr(self.view.result, "recording", None)
        if identifier is None:
            remedy = "wait for its end, or for its first shot"
            raise JobEnded(self.id, "the job has no recording", why=f"it is {self.state}", remedy=remedy)
        return Recording(self._transport, identifier)


class Acquisition(_MakesRecording[AcquisitionResult]):
    """A series of shots."""

    def pause(self) -> JobModel[Any, Any]:
        """Pause after the shot that runs; outputs are off meanwhile."""
        return self._send("pause_acquisition", "{}")

    def resume(self) -> JobModel[Any, Any]:
        """Go on after a pause, or make the missing shots of a series that was cut off."""
        return self._send("resume_acquisition", "{}")

    def shots(self, after: int = 0) -> Iterator[ShotReport]:
        """Shots on disk with numbers above `after`, each with its on-line fit if that is there already."""
        yield from self._transport.items(ShotReport, "get_shots", {"after": after}, identifier=self.id)

    def fits(self) -> pd.DataFrame:
        """One row for each shot: verdict, value and standard deviation of each parameter; units in `.attrs["units"]`.

        Shots whose fit is not there yet are left out.
        """
        return fits_table([shot.fit for shot in self.shots() if shot.fit is not None])


class Procedure(_MakesRecording[ProcedureResult]):
    """A sweep, tune, ramp or characterisation: several series in one recording."""

    def pause(self) -> JobModel[Any, Any]:
        """Pause after the shot that runs; outputs are off meanwhile."""
        return self._send("pause_procedure", "{}")

    def resume(self) -> JobModel[Any, Any]:
        """Go on after a pause."""
        return self._send("resume_procedure", "{}")

    def report(self, path: str | Path | None = None) -> str:
        """Its page as HTML, also written to `path`.  Raises NotFound for a procedure that makes none."""
        return self._page("get_procedure_report", path)

    def steps(self) -> pd.DataFrame:
        """One row for each step: the values of the swept keys, and median and standard deviation of each result."""
        return steps_table(self.result.steps)


class Reproduction(QueuedJob[Claims]):
    """The paper's campaign: both resonators, and its numbers beside the measured ones."""

    def pause(self) -> JobModel[Any, Any]:
        """Pause after the shot that runs; outputs are off meanwhile."""
        return self._send("pause_reproduction", "{}")

    def resume(self) -> JobModel[Any, Any]:
        """Go on after a pause, or after it was cut off: what was measured whole stays."""
        return self._send("resume_reproduction", "{}")

    def report(self, path: str | Path | None = None) -> str:
        """Its page as HTML, also written to `path`."""
        return self._page("get_reproduction_report", path)


class Calibration(QueuedJob[CalibrationReport]):
    """A calibration, which may ask the operator to do something."""

    @property
    def question(self) -> str | None:
        """What the operator has to do before it goes on; None: nothing."""
        found: str | None = getattr(self.view, "question", None)
        return found

    def proceed(self) -> JobModel[Any, Any]:
        """Say that the operator has done what `question` asks for."""
        return self._send("continue_calibration", "{}")


class SelfTest(QueuedJob[SelfTestReport]):
    """A self-test."""


class Fit(Job[FitReport]):
    """A fit of a stored recording."""

    def table(self) -> pd.DataFrame:
        """One row for each frame: verdict, value and standard deviation of each parameter."""
        return fits_table(self.result.frames)

    def budget(self, quantity: str, *, shot: int | None = None, coverage: float = 0.95) -> BudgetReport:
        """The uncertainty budget of a parameter, by the model and the window of this fit.

        quantity: public name of the parameter, as m_r_am2.  shot: one frame, from 0; None: the mean of the recording.
        coverage: probability of the interval value ± U, above 0 and below 1.
        Raises InputError for a fit with further terms, held parameters or hints.
        """
        request = self.view.request
        if request.terms or request.fixed or request.hints:
            what, remedy = "the daemon makes budgets of whole models", "adopt the model that it is, and fit that"
            why = "this fit has further terms, held parameters or hints"
            raise InputError(what, where=self.id, why=why, remedy=remedy)
        recording = Recording(self._transport, request.recording)
        how: dict[str, Any] = {"window": request.window, "variant": request.variant}
        return recording.budget(quantity, shot=shot, coverage=coverage, **how)

    def derived(self) -> DerivedReport:
        """What follows from the fitted parameters, as the quality factors."""
        return self._transport.get(DerivedReport, "get_derived", identifier=self.id)

    def envelopes(self, frame: int = 0, *, points: int | None = None) -> EnvelopesReport:
        """How the deflection of a frame decays by its fit; points: at most so many."""
        query = {"points": points}
        return self._transport.get(EnvelopesReport, "get_envelopes", query, identifier=self.id, frame=frame)


class Diagnosis(Job[DiagnosisReport]):
    """A diagnosis: what the declared model lacks."""

    def report(self, path: str | Path | None = None) -> str:
        """Its page as HTML, also written to `path`."""
        return self._page("get_report", path)

    def adopt(self, name: str, *, by: str, **values: Any) -> AdoptedModelRecord:
        """Adopt what it names as a model for later fits, NAME@VERSION.

        name: NAME, the daemon counts the versions; by: who adopts it; values: effects, free, force of an
        AdoptionRequest.
        """
        body = request_from(AdoptionRequest, {"name": name, "by": by, **values}, "adopt")
        return self._transport.post(AdoptedModelRecord, "adopt_model", body, identifier=self.id)


class Characterisation(Job[CharacterisationReport]):
    """The paper's tables from a stored recording."""

    def report(self, path: str | Path | None = None) -> str:
        """Its page as HTML, also written to `path`."""
        return self._page("get_characterisation_report", path)


CLASSES: dict[str, type[Job[Any]]] = {
    "acquisition": Acquisition,
    "procedure": Procedure,
    "reproduction": Reproduction,
    "calibration": Calibration,
    "self_test": SelfTest,
    "fit": Fit,
    "diagnosis": Diagnosis,
    "characterisation": Characterisation,
}


def job_of(transport: Transport, view: JobModel[Any, Any]) -> Job[Any]:
    """The job of a view, of the class of its kind."""
    other = QueuedJob if feature_of(view.kind).kind.needs_hardware else Job
    return CLASSES.get(view.kind, other)(transport, view)


def id_of(named: Job[Any] | Recording | str) -> str:
    """The id of a job or recording that is given by itself or its id."""
    return named if isinstance(named, str) else named.id
