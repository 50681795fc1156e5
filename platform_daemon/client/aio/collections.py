"""What the daemon keeps by name: schedules, specimens, resonators, sequences, models."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from pathlib import Path
from typing import Any

from drivers.specimen import Specimen
from platform_daemon.client.answers import not_found
from platform_daemon.client.requests import request_from, takes, text_of
from platform_daemon.client.works import work_of
from platform_daemon.core.schemas.platform import CatalogueEntry, ResonatorInfo, SequenceInfo
from platform_daemon.core.schemas.requests import SequencePatch
from platform_daemon.features.design.schema import DesignReport
from platform_daemon.features.measurand.schema import MeasurandCalibration
from platform_daemon.features.models.schema import AdoptedModelReport, AdoptedModelSummary, RetirementRequest
from platform_daemon.features.schedules.schema import LedgerRow, Schedule, SchedulePreview, ScheduleRequest
from platform_daemon.features.sensor_calibration.schema import MeasurandRequest
from platform_daemon.features.trends.schema import Baseline, BaselineRequest, SpecimenPage, TrendReport

from .transport import AsyncTransport

_TRIGGER = ("every_s", "cron", "at", "time_zone", "jitter_s")


class AsyncScheduleHandle:
    """One schedule, by its name or its id."""

    def __init__(self, transport: AsyncTransport, name: str) -> None:
        self._transport, self.name = transport, name
        self._id: str | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"

    async def get(self) -> Schedule:
        """The schedule as it is.  Raises NotFound."""
        return await self._transport.get(Schedule, "get_schedule", identifier=await self._identifier())

    async def ledger(self, after: int = 0) -> AsyncIterator[LedgerRow]:
        """What became of its due instants, oldest first; after: rows with larger numbers."""
        identifier = await self._identifier()
        async for row in self._transport.items(LedgerRow, "get_ledger", {"after": after}, identifier=identifier):
            yield row

    async def pause(self) -> Schedule:
        """It starts nothing until it is resumed."""
        return await self._transport.post(Schedule, "pause_schedule", identifier=await self._identifier())

    async def resume(self) -> Schedule:
        """It starts again what comes due."""
        return await self._transport.post(Schedule, "resume_schedule", identifier=await self._identifier())

    async def run(self) -> LedgerRow:
        """Start its work once, now."""
        return await self._transport.post(LedgerRow, "run_schedule", identifier=await self._identifier())

    async def remove(self) -> Schedule:
        """It starts nothing any more; what it has started stays."""
        return await self._transport.get(Schedule, "remove_schedule", identifier=await self._identifier())

    async def _identifier(self) -> str:
        """Raises NotFound, also if two schedules have the name."""
        if self._id is None:
            known = [each async for each in self._transport.items(Schedule, "list_schedules")]
            names = {each.id: each.request.name if each.request is not None else each.id for each in known}
            found = [each for each, name in names.items() if self.name in (each, name)]
            if len(found) != 1:
                raise not_found("schedule" if not found else "single schedule", self.name, [*names.values(), *found])
            self._id = found[0]
        return self._id


class AsyncSchedules:
    """The schedules: `schedules["night"]` is one of them, by name or id."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    def __getitem__(self, name: str) -> AsyncScheduleHandle:
        return AsyncScheduleHandle(self._transport, name)

    __iter__ = None  # else `for` would ask for 0, 1, 2, ... without end: `list` has them all

    async def list(self) -> AsyncIterator[Schedule]:
        """All schedules, oldest first."""
        async for each in self._transport.items(Schedule, "list_schedules"):
            yield each

    async def add(self, name: str, **values: Any) -> Schedule:
        """Add a schedule, as add("night", measure={"resonator": "jewel", "shots": 20}, cron="0 22 * * *").

        name: what people call it; values: one work: the arguments of that method as measure, sweep, tune, ramp,
        characterise, calibrate or self_test, or `work` as ScheduleRequest has it; one trigger: every_s (interval, s,
        from `start` on: without `start` it is due at once), cron (five fields) or at (times, ISO 8601), with time_zone
        (IANA name) and jitter_s; and the other keys of a ScheduleRequest: resonators, grace_s, policy, priority, start,
        until, max_failures.
        """
        return await self._transport.post(Schedule, "add_schedule", _schedule_request(name, values))

    async def preview(self, name: str = "preview", *, count: int | None = None, **values: Any) -> SchedulePreview:
        """When a schedule with this name and these values, see `add`, would start; count: how many instants."""
        body = _schedule_request(name, values)
        return await self._transport.post(SchedulePreview, "preview_schedule", body, {"count": count})


def _schedule_request(name: str, values: Mapping[str, Any]) -> ScheduleRequest:
    works = ("measure", "sweep", "tune", "ramp", "characterise", "calibrate", "self_test", "work")
    trigger = {key: values[key] for key in _TRIGGER if key in values}
    rest = {key: value for key, value in values.items() if key not in (*works, *_TRIGGER)}
    work = work_of({key: values.get(key) for key in works})
    return request_from(ScheduleRequest, {"name": name, "trigger": trigger, "work": work, **rest}, "schedules.add")


class AsyncSpecimenHandle:
    """One specimen: all recordings of one sample."""

    def __init__(self, transport: AsyncTransport, name: str) -> None:
        self._transport, self.name = transport, name

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"

    async def get(self) -> SpecimenPage:
        """What is known of it: recordings, resonators, calibrations, models, changes.  Raises NotFound."""
        return await self._transport.get(SpecimenPage, "get_specimen", specimen=self.name)

    async def trend(
        self,
        *,
        since: str | None = None,
        until: str | None = None,
        step: str | None = None,
        newest: int | None = None,
        uncertainty: bool = False,
    ) -> TrendReport:
        """Its quantities over time, and the changes in them.

        since, until: ISO 8601, None: all; step: number or name of a step of procedures, None: the last one; newest: so
        many points at most, None: all; uncertainty: U of every value, which takes some fits for each calibration.
        """
        query = {"since": since, "until": until, "step": step, "newest": newest, "uncertainty": uncertainty or None}
        return await self._transport.get(TrendReport, "get_trend", query, specimen=self.name)

    async def trend_table(
        self,
        *,
        since: str | None = None,
        until: str | None = None,
        step: str | None = None,
        uncertainty: bool = False,
    ) -> str:
        """The same as a table in CSV; since, until, step, uncertainty: as of `trend`."""
        query = {"since": since, "until": until, "step": step, "uncertainty": uncertainty or None}
        return (await self._transport.send("get_trend_table", query=query, specimen=self.name)).text

    async def trend_picture(
        self, path: str | Path | None = None, *, since: str | None = None, step: str | None = None
    ) -> bytes:
        """The same as a PNG, also written to `path`; since, step: as of `trend`."""
        query = {"since": since, "step": step}
        picture = (await self._transport.send("get_trend_picture", query=query, specimen=self.name)).content
        if path is not None:
            Path(path).write_bytes(picture)
        return picture

    async def accept(self, *, by: str, reason: str, since: str | None = None) -> Baseline:
        """Take what it is now as normal: changes before `since` (ISO 8601; None: now) raise no alarm any more.

        by: who does; reason: why, both for the record.
        """
        values = {"by": by, "reason": reason, **({} if since is None else {"since": since})}
        body = request_from(BaselineRequest, values, "accept")
        return await self._transport.post(Baseline, "accept_specimen", body, specimen=self.name)


class AsyncSpecimens:
    """The specimens: `specimens["T-07"]` is one of them."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    def __getitem__(self, name: str) -> AsyncSpecimenHandle:
        return AsyncSpecimenHandle(self._transport, name)

    __iter__ = None  # else `for` would ask for 0, 1, 2, ... without end: `list` has them all

    async def list(self) -> AsyncIterator[str]:
        """The names of all specimens."""
        async for each in self._transport.items(str, "list_specimens"):
            yield each


class AsyncResonators:
    """The resonators that can be measured, by name."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    async def list(self) -> AsyncIterator[ResonatorInfo]:
        """All resonators."""
        async for each in self._transport.items(ResonatorInfo, "list_resonators"):
            yield each

    async def get(self, name: str) -> Specimen:
        """What is declared of the one of that name.  Raises NotFound."""
        return await self._transport.get(Specimen, "get_resonator", name=name)

    async def add(self, name: str, specimen: Specimen | Mapping[str, Any]) -> CatalogueEntry:
        """Add one; specimen: as `get` returns them, or its keys.  Raises Conflict if the name is taken."""
        body = specimen if isinstance(specimen, Specimen) else request_from(Specimen, specimen, "resonators.add")
        return await self._transport.post(CatalogueEntry, "add_resonator", body, {"name": name})

    @takes(MeasurandRequest)
    async def calibrate(self, specimen: str, **values: Any) -> MeasurandCalibration:
        """Calibrate one as a sensor, by the recordings of a `schedule` or by `recordings`.

        reference: readings of the reference as CSV, their text or the `Path` of a file; None: the platform's
        thermometer, for a measurand `temperature` in degC.
        """
        given = {name: value for name, value in values.items() if value is not None}
        if isinstance(reference := given.get("reference"), Path):
            given["reference"] = text_of(reference, "reference")
        body = request_from(MeasurandRequest, {"specimen": specimen, **given}, "resonators.calibrate")
        return await self._transport.post(MeasurandCalibration, "calibrate_measurand", body)

    async def design(self, name: str) -> DesignReport:
        """What the design equations of the paper say of the one of that name."""
        return await self._transport.get(DesignReport, "get_design", name=name)


class AsyncSequences:
    """The sequences that `preset` of a measurement may name."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    async def list(self) -> AsyncIterator[SequenceInfo]:
        """All sequences."""
        async for each in self._transport.items(SequenceInfo, "list_sequences"):
            yield each

    async def get(self, name: str) -> SequencePatch:
        """The keys of the one of that name.  Raises NotFound."""
        return await self._transport.get(SequencePatch, "get_sequence", name=name)

    async def add(self, name: str, **values: Any) -> CatalogueEntry:
        """Add one, as add("weak", field_ut=50).  Raises Conflict if the name is taken."""
        body = request_from(SequencePatch, values, "sequences.add")
        return await self._transport.post(CatalogueEntry, "add_sequence", body, {"name": name})


class AsyncModels:
    """The adopted models."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    async def list(self) -> AsyncIterator[AdoptedModelSummary]:
        """Every version of every adopted model."""
        async for each in self._transport.items(AdoptedModelSummary, "list_models"):
            yield each

    async def get(self, name: str) -> AdoptedModelReport:
        """One; name: NAME (its newest version) or NAME@VERSION.  Raises NotFound."""
        return await self._transport.get(AdoptedModelReport, "get_model", name=name)

    async def retire(self, name: str, *, reason: str, by: str = "") -> AdoptedModelSummary:
        """Take a version out of use; earlier results keep it.

        name: NAME@VERSION; reason: why, for the record; by: who.
        """
        body = request_from(RetirementRequest, {"reason": reason, "by": by}, "retire")
        return await self._transport.post(AdoptedModelSummary, "retire_model", body, name=name)
