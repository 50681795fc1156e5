"""Numbers for Prometheus: counted from the events, or read at each scrape."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from pathlib import Path

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest

from drivers.errors import PlatformError
from platform_daemon.core.schemas.events import AnyEvent, FitEvent, JobEvent, MeasurandEvent, ScheduleEvent, ShotEvent
from platform_daemon.core.service.platform_service import PlatformService

_FIT_S = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)


class Metrics:
    """Counts since this process began, which Prometheus expects to start from zero.  open_alarms: how many there are;
    folder: whose disk is looked at."""

    def __init__(self, hardware: PlatformService, open_alarms: Callable[[], int], folder: Path) -> None:
        self._hardware, self._open_alarms, self._folder = hardware, open_alarms, folder
        self._registry = every = CollectorRegistry()
        self._jobs = Counter("mmr_jobs", "Jobs by kind and state that they came to", ["kind", "state"], registry=every)
        self._shots = Counter("mmr_shots", "Shots on disk", ["verdict"], registry=every)
        self._fits = Counter("mmr_fits", "On-line fits", ["verdict"], registry=every)
        self._fit_s = Histogram("mmr_fit_seconds", "Computing time of an on-line fit", buckets=_FIT_S, registry=every)
        self._rows = Counter("mmr_schedule_rows", "Rows of ledgers by what became of them", ["state"], registry=every)
        of = ["specimen", "name", "unit"]
        self._value = Gauge("mmr_measurand", "Newest reading of a resonator as a sensor", of, registry=every)
        self._expanded = Gauge("mmr_measurand_expanded_uncertainty", "U of it, 95 %", of, registry=every)
        self._up = Gauge("mmr_hardware_up", "1: the owner of the hardware answers", registry=every)
        self._queued = Gauge("mmr_queued_jobs", "Jobs that wait for the platform", registry=every)
        self._running = Gauge("mmr_running_jobs", "Jobs that have the platform", registry=every)
        self._closed = Gauge("mmr_interlock_closed", "1: no power may go out", registry=every)
        self._celsius = Gauge("mmr_temperature_celsius", "Temperature of the platform", registry=every)
        self._standing = Gauge("mmr_alarms", "Alarms that stand", registry=every)
        self._disk = Gauge("mmr_disk_free_bytes", "Left on the disk of the data folder", registry=every)

    def see(self, what: AnyEvent) -> None:
        """Count an event."""
        match what:
            case JobEvent():
                self._jobs.labels(what.job_kind, str(what.state)).inc()
            case ShotEvent():
                self._shots.labels(what.verdict).inc()
            case FitEvent():
                self._fits.labels(what.verdict).inc()
                self._fit_s.observe(what.seconds)
            case MeasurandEvent():
                labels = what.specimen, what.name, what.unit
                # Without a reading NaN: the one before is no longer true.
                self._value.labels(*labels).set(math.nan if what.value is None else what.value)
                self._expanded.labels(*labels).set(math.nan if what.U is None else what.U)
            case ScheduleEvent():
                self._rows.labels(what.state).inc()
            case _:
                pass

    def text(self) -> bytes:
        """All numbers in the text format."""
        self._standing.set(self._open_alarms())
        self._disk.set(shutil.disk_usage(self._folder).free)
        for each in (self._queued, self._running, self._closed, self._celsius):
            each.set(math.nan)  # until it is known: 0 would be a value
        try:
            status = self._hardware.status()
        except PlatformError:
            self._up.set(0)
            return generate_latest(self._registry)
        self._up.set(1)
        self._queued.set(len(status.queued))
        self._running.set(status.running is not None)
        self._closed.set(status.interlock is not None)
        if status.temperature_c is not None:
            self._celsius.set(status.temperature_c)
        return generate_latest(self._registry)
