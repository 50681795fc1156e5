"""The one thread that moves anything: it works through a queue of jobs, and reads the devices back between them.

A second thread conducts procedures, which put their steps into that queue.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial

import structlog

from drivers.errors import DeviceStateError, PlatformError
from drivers.platform import Platform
from drivers.realtime import set_realtime_priority
from platform_daemon.core.jobs.hardware_queue import Ended, HardwareQueue
from platform_daemon.core.jobs.jobs import AnyJob

from .interlock import Interlock
from .readback import Readback

log = structlog.get_logger()
JUST_ENDED_S = 1.0  # how long after its end a job may still hold the hardware
IDLE_S = 1.0  # how often the state is read back while nothing runs
_END_S = 60.0


def run_job(job: AnyJob, work: Callable[[AnyJob], None]) -> None:
    """Run a job to its end and say how it ended."""
    log.info("job_started", job=job.identifier)
    job.run(work)
    error = None if job.error is None else str(job.error)
    log.info("job_ended", job=job.identifier, state=str(job.state), error=error)


class HardwareThread:
    """Begins at once, with what takes long the first time (unless `warms_up` is False); jobs wait for that.

    warm: set once it is done; queue: what waits; ends: no further job is begun.
    """

    def __init__(
        self,
        platform: Platform,
        interlock: Interlock,
        readback: Readback,
        ends: threading.Event,
        *,
        warms_up: bool = True,
    ) -> None:
        self._warms_up = warms_up
        self._platform, self._interlock, self._readback, self._ends = platform, interlock, readback, ends
        self.warm = threading.Event()
        self.queue = HardwareQueue()
        self._hardware = threading.Lock()  # held while a job moves something
        self._thread = threading.Thread(target=self._work, name="hardware", daemon=True)
        self._thread.start()
        self._conducting = threading.Thread(target=self._conduct, name="procedures", daemon=True)
        self._conducting.start()

    @property
    def alive(self) -> bool:
        """It has not ended."""
        return self._thread.is_alive()

    def put(self, job: AnyJob, work: Callable[[AnyJob], None]) -> None:
        """Queue it: its work is done behind the interlock, that of a procedure by its steps."""
        self.queue.put(job, work)

    def put_end(self) -> None:
        """Begin nothing more."""
        self.queue.put_end()

    def join(self) -> None:
        """Wait until it has ended, a minute at most."""
        self._thread.join(timeout=_END_S)

    def join_procedures(self) -> None:
        """Wait until none writes any more."""
        self._conducting.join()

    @contextmanager
    def at_rest(self) -> Iterator[None]:
        """No job moves anything, and outputs are proved off.  Raises DeviceStateError while one does, DeviceError."""
        if not self._hardware.acquire(timeout=JUST_ENDED_S):
            remedy = "wait until it has ended, or cancel it"
            raise DeviceStateError("a series or a calibration is running", where="power_amplifier", remedy=remedy)
        try:
            self._interlock.prove_off()
            yield
        finally:
            self.refresh()
            self._hardware.release()

    def refresh(self, *, busy: bool = False) -> None:
        """Read the devices back; an error is logged."""
        try:
            self._readback.refresh(busy=busy)
        except Exception as error:  # the thread that owns the hardware must outlive any device
            log.error("status_failed", error=str(error), exc_info=not isinstance(error, PlatformError))

    def _work(self) -> None:
        if self._warms_up:
            self._warm_up()
        ordinary = set_realtime_priority(self._platform.clock)
        log.info("hardware_thread_begun", urgent=ordinary is None, why=ordinary)
        while True:
            try:
                item = self.queue.take(IDLE_S)
            except Ended:
                return
            if self._ends.is_set():
                return
            if item is not None:
                with self._hardware:
                    run_job(item.job, partial(self._interlock.run, item.work))
            self._interlock.recover()
            self.refresh()

    def _conduct(self) -> None:
        with suppress(Ended):
            while not self._ends.is_set():
                item = self.queue.take(IDLE_S, procedures=True)
                if item is not None:
                    run_job(item.job, item.work)

    def _warm_up(self) -> None:
        try:
            self._platform.warm_up()
            self.warm.set()
        except Exception as error:  # the first job will meet the same error and report it
            log.error("platform_warm_up_failed", error=str(error))
