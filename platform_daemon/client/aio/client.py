"""The client of a daemon."""

from __future__ import annotations

import os
import uuid
from collections.abc import AsyncIterator, Collection, Iterable, Mapping, Sequence
from contextlib import aclosing
from pathlib import Path
from types import TracebackType
from typing import Any, cast

from pydantic import BaseModel

from drivers.errors import InputError
from platform_daemon.client.requests import request_from, several, takes
from platform_daemon.client.works import procedure_request
from platform_daemon.core.jobs.kinds import job_type
from platform_daemon.core.registry import feature_of
from platform_daemon.core.schemas.access import AuditEntry, CallerInfo
from platform_daemon.core.schemas.acquisitions import AcquisitionSummary
from platform_daemon.core.schemas.calibrations import CalibrationsInUse
from platform_daemon.core.schemas.events import Event, EventKind
from platform_daemon.core.schemas.harmonics import ShotHarmonics
from platform_daemon.core.schemas.job_list import JobSummary
from platform_daemon.core.schemas.platform import DeviceReadback, FaultReset, PlatformStatus, Readiness
from platform_daemon.core.schemas.problems import ProblemKind
from platform_daemon.core.schemas.requests import AcquisitionRequest, ActivationRequest, CalibrationRequest
from platform_daemon.core.schemas.stop import Health, StopReport
from platform_daemon.core.schemas.unattended import (
    FaultCleared,
    FaultUnlock,
    MountedResonator,
    MountRequest,
    QueueOrder,
)
from platform_daemon.features.alarms.schema import Acknowledgement, Alarm
from platform_daemon.features.characterise.schema import CharacterisationRequest, CharacteriseRequest
from platform_daemon.features.design.schema import DefectsReport, DefectsRequest, DesignReport
from platform_daemon.features.diagnose.request_schema import DiagnosisRequest
from platform_daemon.features.fit.prediction_schema import PredictionReport
from platform_daemon.features.fit.request_schema import PredictionRequest, RecordingFitRequest
from platform_daemon.features.measurand.schema import MeasurandCalibration
from platform_daemon.features.models.schema import AdoptedModelRecord
from platform_daemon.features.procedures.schema import ProcedureSummary
from platform_daemon.features.ramp.schema import RampRequest
from platform_daemon.features.reproduce.schema import ReproductionRequest
from platform_daemon.features.self_test.schema import SelfTestRequest
from platform_daemon.features.sweep.schema import SweepRequest
from platform_daemon.features.tune.schema import TuneRequest

from .collections import AsyncModels, AsyncResonators, AsyncSchedules, AsyncSequences, AsyncSpecimens
from .events import follow
from .jobs import (
    AsyncAcquisition,
    AsyncCalibration,
    AsyncCharacterisation,
    AsyncDiagnosis,
    AsyncFit,
    AsyncJob,
    AsyncProcedure,
    AsyncReproduction,
    AsyncSelfTest,
    id_of,
    job_of,
)
from .recordings import AsyncRecording, AsyncRecordings
from .transport import AsyncTransport


class AsyncClient:
    """A daemon, over its REST interface.

    Every method may raise ConnectionFailed, NotADaemon or VersionMismatch, and Refused where the daemon refuses.
    Requests that cannot do anything twice are repeated for 30 s while the daemon does not answer; those that start a
    job have an idempotency key.

    Args:
        url: address of the daemon, as http://127.0.0.1:8212; None: that of the variable PLATFORM_DAEMON_URL.
        token: None: that of PLATFORM_DAEMON_TOKEN, or none if the daemon needs none.
        ca_file: certificate (PEM) that the daemon's is checked against; None: the certificates of the system.
    """

    def __init__(self, url: str | None = None, *, token: str | None = None, ca_file: str | Path | None = None) -> None:
        place = url or os.environ.get("PLATFORM_DAEMON_URL")
        if not place:
            remedy = "give it, as http://127.0.0.1:8212, or set PLATFORM_DAEMON_URL"
            raise InputError("the address of the daemon is not known", where="url", remedy=remedy)
        self._transport = AsyncTransport(place, token or os.environ.get("PLATFORM_DAEMON_TOKEN") or None, ca_file)
        self.schedules = AsyncSchedules(self._transport)
        self.specimens = AsyncSpecimens(self._transport)
        self.recordings = AsyncRecordings(self._transport)
        self.resonators = AsyncResonators(self._transport)
        self.sequences = AsyncSequences(self._transport)
        self.models = AsyncModels(self._transport)

    async def __aenter__(self) -> AsyncClient:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.aclose()

    async def aclose(self) -> None:
        """Close the connections; jobs go on.  Idempotent."""
        await self._transport.aclose()

    # Jobs on the platform

    @takes(AcquisitionRequest)
    async def measure(self, resonator: str, *, idempotency_key: str | None = None, **values: Any) -> AsyncAcquisition:
        """Measure a series of shots on a resonator, and fit each."""
        body = request_from(AcquisitionRequest, {"resonator": resonator, **values}, "measure")
        return cast(AsyncAcquisition, await self._start("acquisition", body, idempotency_key))

    @takes(SweepRequest, "kind")
    async def sweep(
        self,
        resonator: str,
        *,
        over: Mapping[str, Iterable[Any]] | Sequence[Mapping[str, Any]],
        idempotency_key: str | None = None,
        **values: Any,
    ) -> AsyncProcedure:
        """Measure the same series with other values of some keys, step by step.

        over: the values by key, as {"field_ut": range(50, 301, 50)}; of several keys all combinations.
        """
        return await self._procedure("sweep", {"resonator": resonator, "over": over, **values}, idempotency_key)

    @takes(TuneRequest, "kind")
    async def tune(self, resonator: str, *, idempotency_key: str | None = None, **values: Any) -> AsyncProcedure:
        """Find the resonator's frequency, and the sequence that it is measured best with."""
        return await self._procedure("tune", {"resonator": resonator, **values}, idempotency_key)

    @takes(RampRequest, "kind")
    async def ramp(self, resonator: str, *, idempotency_key: str | None = None, **values: Any) -> AsyncProcedure:
        """Raise the field step by step until side modes show."""
        return await self._procedure("ramp", {"resonator": resonator, **values}, idempotency_key)

    @takes(CharacteriseRequest, "kind")
    async def characterise(
        self, resonator: str, *, idempotency_key: str | None = None, **values: Any
    ) -> AsyncProcedure:
        """Measure many shots of one resonator, and make the paper's tables of them."""
        return await self._procedure("characterise", {"resonator": resonator, **values}, idempotency_key)

    @takes(CalibrationRequest)
    async def calibrate(self, kind: str, *, idempotency_key: str | None = None, **values: Any) -> AsyncCalibration:
        """Calibrate the receive side with a reference dipole, or the transmit side with a field probe.

        kind: receive or transmit.
        """
        body = request_from(CalibrationRequest, {"kind": kind, **values}, "calibrate")
        return cast(AsyncCalibration, await self._start("calibration", body, idempotency_key))

    @takes(SelfTestRequest)
    async def self_test(self, *, idempotency_key: str | None = None, **values: Any) -> AsyncSelfTest:
        """Test the chain of coils, switch and receiver with weak tones."""
        body = request_from(SelfTestRequest, values, "self_test")
        return cast(AsyncSelfTest, await self._start("self_test", body, idempotency_key))

    @takes(ReproductionRequest)
    async def reproduce(self, *, idempotency_key: str | None = None, **values: Any) -> AsyncReproduction:
        """Measure a thread and a jewel as the paper did, and compare each of its numbers with the measured one."""
        body = request_from(ReproductionRequest, values, "reproduce")
        return cast(AsyncReproduction, await self._start("reproduction", body, idempotency_key))

    async def start_procedure(self, request: BaseModel, *, idempotency_key: str | None = None) -> AsyncProcedure:
        """Start a procedure from its request, a SweepRequest, TuneRequest, RampRequest or CharacteriseRequest.

        idempotency_key: a call that is repeated with it returns the first job; None: a new one.
        """
        return cast(AsyncProcedure, await self._start("procedure", request, idempotency_key))

    @takes(AcquisitionRequest)
    async def dry_run(self, resonator: str, **values: Any) -> AcquisitionSummary:
        """What `measure` with these arguments would play, how long it takes, and what may spoil it; nothing moves."""
        body = request_from(AcquisitionRequest, {"resonator": resonator, **values}, "measure")
        return await self._transport.post(AcquisitionSummary, "dry_run", body)

    async def dry_run_procedure(self, kind: str, resonator: str, **values: Any) -> ProcedureSummary:
        """The same for a procedure.

        kind: sweep, tune, ramp or characterise; resonator and values: the arguments of the method of that name.
        """
        body = procedure_request(kind, {"resonator": resonator, **values})
        return await self._transport.post(ProcedureSummary, "dry_run_procedure", body)

    # Jobs on recordings

    @takes(RecordingFitRequest)
    async def fit(
        self, recording: str | AsyncRecording, *, idempotency_key: str | None = None, **values: Any
    ) -> AsyncFit:
        """Fit a stored recording, given by its id or itself."""
        body = request_from(RecordingFitRequest, {"recording": id_of(recording), **values}, "fit")
        return cast(AsyncFit, await self._start("fit", body, idempotency_key))

    @takes(DiagnosisRequest, "recordings")
    async def diagnose(
        self, *recordings: str | AsyncRecording, idempotency_key: str | None = None, **values: Any
    ) -> AsyncDiagnosis:
        """Find what the model of a resonator lacks; several recordings of it are diagnosed together."""
        chosen = [id_of(each) for each in recordings]
        body = request_from(DiagnosisRequest, {"recordings": chosen, **values}, "diagnose")
        return cast(AsyncDiagnosis, await self._start("diagnosis", body, idempotency_key))

    @takes(CharacterisationRequest)
    async def characterise_recording(
        self, recording: str | AsyncRecording, *, idempotency_key: str | None = None, **values: Any
    ) -> AsyncCharacterisation:
        """Make the paper's tables of a stored recording."""
        chosen = {"recording": id_of(recording), **values}
        body = request_from(CharacterisationRequest, chosen, "characterise_recording")
        return cast(AsyncCharacterisation, await self._start("characterisation", body, idempotency_key))

    async def adopt(self, diagnosis: AsyncDiagnosis | str, name: str, *, by: str, **values: Any) -> AdoptedModelRecord:
        """Adopt what a diagnosis names as a model for later fits.

        diagnosis: its job or id; name, by and values: as of Diagnosis.adopt.  Raises InputError for another job.
        """
        job = await self.job(diagnosis) if isinstance(diagnosis, str) else diagnosis
        if not isinstance(job, AsyncDiagnosis):
            raise InputError(f"{job!r} is no diagnosis", where="diagnosis", remedy="give what `diagnose` returned")
        return await job.adopt(name, by=by, **values)

    async def _procedure(self, kind: str, values: Mapping[str, Any], key: str | None) -> AsyncProcedure:
        return await self.start_procedure(procedure_request(kind, values), idempotency_key=key)

    async def _start(self, kind: str, body: BaseModel, key: str | None) -> AsyncJob[Any]:
        view = await self._transport.post(job_type(kind), f"start_{kind}", body, key=key or str(uuid.uuid4()))
        return job_of(self._transport, view)

    # Jobs there are

    async def job(self, identifier: str) -> AsyncJob[Any]:
        """The job with the id `identifier`.  Raises NotFound, InputError for an id of no kind of job."""
        kind = identifier.partition("-")[0]
        view = await self._transport.get(job_type(kind), f"get_{kind}", identifier=identifier)
        return job_of(self._transport, view)

    async def jobs(
        self, *, state: str | Sequence[str] = (), kind: str | Sequence[str] = ()
    ) -> AsyncIterator[JobSummary]:
        """All jobs in short, newest first; state, kind: only these; empty: all."""
        query = {"state": several(state), "kind": several(kind)}
        async for each in self._transport.items(JobSummary, "list_jobs", query):
            yield each

    async def jobs_of(self, kind: str) -> AsyncIterator[AsyncJob[Any]]:
        """All jobs of a kind with their results, oldest first."""
        plural = feature_of(kind).kind.plural.replace("-", "_")
        async for view in self._transport.items(job_type(kind), f"list_{plural}"):
            yield job_of(self._transport, view)

    async def events(
        self,
        job: AsyncJob[Any] | str | None = None,
        *,
        kinds: Collection[EventKind] = (),
        after: int | None = None,
    ) -> AsyncIterator[Event]:
        """Events as they happen; a stream that is cut off is resumed with the next event.

        job: only of this job and its steps, from its beginning to its end; None: of everything, without end.
        kinds: only these; empty: all.  after: begin after the event of this number; None: with those that come.
        Raises EventsDropped if some were missed.
        """
        identifier = id_of(job) if job is not None else None
        chosen = {*kinds, "job"} if kinds and identifier is not None else kinds  # its end ends the stream
        begin = 0 if identifier is not None and after is None else after
        async with aclosing(follow(self._transport, job=identifier, kinds=chosen, after=begin)) as events:
            async for event in events:
                if not kinds or event.what.kind in kinds:
                    yield event

    # The platform

    async def stop(self) -> StopReport:
        """Switch all outputs off, and cancel everything that moves or waits."""
        return await self._transport.post(StopReport, "stop")

    async def health(self) -> Health:
        """That the daemon is alive, and its version."""
        return await self._transport.get(Health, "get_health")

    async def readiness(self) -> Readiness:
        """Whether it can measure, and what is missing.  Raises Unavailable if it is not ready."""
        return await self._transport.get(Readiness, "get_readiness")

    async def caller(self) -> CallerInfo:
        """Who this client is to the daemon, and in which role."""
        return await self._transport.get(CallerInfo, "get_caller")

    async def platform(self) -> PlatformStatus:
        """Devices as last read back, what runs, and what waits."""
        return await self._transport.get(PlatformStatus, "get_platform")

    async def devices(self) -> AsyncIterator[DeviceReadback]:
        """Each device as last read back."""
        async for each in self._transport.items(DeviceReadback, "list_devices"):
            yield each

    async def order_queue(
        self, order: Sequence[str] = (), *, priority: Mapping[str, int] | None = None
    ) -> PlatformStatus:
        """Put waiting jobs in another order; order: ids of those that come first; priority: new ones by id."""
        values = {"order": list(order), "priority": dict(priority or {})}
        body = request_from(QueueOrder, values, "order_queue")
        return await self._transport.post(PlatformStatus, "order_queue", body)

    async def mounted_resonator(self) -> MountedResonator:
        """The resonator in the clamping unit, as far as it is known."""
        return await self._transport.get(MountedResonator, "get_mounted_resonator")

    async def mount(self, resonator: str, *, by: str = "") -> MountedResonator:
        """Say that this resonator is in the clamping unit now; by: who says so."""
        body = request_from(MountRequest, {"resonator": resonator, "by": by}, "mount")
        return await self._transport.post(MountedResonator, "set_mounted_resonator", body)

    async def reset_amplifier(self) -> FaultReset:
        """Clear the latched fault of the power amplifier."""
        return await self._transport.post(FaultReset, "reset_amplifier")

    async def reset_fault(self, *, by: str) -> FaultCleared:
        """Clear the fault that a dead owner of the devices has left; by: who has looked at the platform."""
        body = request_from(FaultUnlock, {"by": by}, "reset_fault")
        return await self._transport.post(FaultCleared, "reset_fault", body)

    async def adopt_calibration(self, kind: str, calibration: str | None = None) -> CalibrationsInUse:
        """Use another calibration from the next series on.

        kind: receive or transmit; calibration: as lab@2_20261121, None: that of the platform file.
        """
        body = request_from(ActivationRequest, {"kind": kind, "calibration": calibration}, "adopt_calibration")
        return await self._transport.post(CalibrationsInUse, "adopt_calibration", body)

    async def live_harmonics(self) -> ShotHarmonics:
        """The harmonics of the last excited shot.  Raises NotFound if there was none."""
        return await self._transport.get(ShotHarmonics, "get_live_harmonics")

    async def changes(self) -> AsyncIterator[AuditEntry]:
        """Who changed, started and stopped what, newest first."""
        async for each in self._transport.items(AuditEntry, "list_changes"):
            yield each

    async def measurands(self) -> AsyncIterator[MeasurandCalibration]:
        """Calibrations of resonators that are sensors, every version."""
        async for each in self._transport.items(MeasurandCalibration, "list_measurands"):
            yield each

    async def measurand(self, name: str) -> MeasurandCalibration:
        """A calibration.  name: KEY, which is its newest version, or KEY@VERSION."""
        return await self._transport.get(MeasurandCalibration, "get_measurand", name=name)

    async def alarms(self) -> AsyncIterator[Alarm]:
        """The alarms that are active."""
        async for each in self._transport.items(Alarm, "list_alarms"):
            yield each

    async def acknowledge(self, alarm: str, *, by: str) -> Alarm:
        """Say that a person knows of an alarm; by: who."""
        body = request_from(Acknowledgement, {"by": by}, "acknowledge")
        return await self._transport.post(Alarm, "acknowledge_alarm", body, name=alarm)

    async def metrics(self) -> str:
        """The measured values of the daemon itself, in the form of Prometheus."""
        return (await self._transport.send("get_metrics")).text

    async def problem_kind(self, kind: str) -> ProblemKind:
        """What a kind of problem means, as `type` of a Refused names it."""
        return await self._transport.get(ProblemKind, "get_problem_kind", kind=kind.rpartition("/")[2])

    # Predictions

    @takes(PredictionRequest)
    async def predict(self, resonator: str, **values: Any) -> PredictionReport:
        """The smallest standard deviations that a planned measurement can have.  Raises InvalidRequest."""
        body = request_from(PredictionRequest, {"resonator": resonator, **values}, "predict")
        return await self._transport.post(PredictionReport, "predict", body)

    async def design(self) -> DesignReport:
        """What the design equations say of the paper's resonator; `resonators.design` has any other."""
        return await self._transport.get(DesignReport, "get_paper_design")

    @takes(DefectsRequest)
    async def defects(self, **values: Any) -> DefectsReport:
        """What a manufacturing defect does to a resonator, in some sizes and at some deflections."""
        body = request_from(DefectsRequest, values, "defects")
        return await self._transport.post(DefectsReport, "compute_defects", body)

    @takes(DefectsRequest)
    async def defects_picture(self, **values: Any) -> bytes:
        """The same as a PNG."""
        body = request_from(DefectsRequest, values, "defects")
        return (await self._transport.send("draw_defects", content=body.model_dump_json())).content
