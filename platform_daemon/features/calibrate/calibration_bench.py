"""What the calibrations share: the bench that their shots are made on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
import structlog
from numpy.typing import NDArray

from drivers.errors import ConfigError, DeviceFault, InputError
from drivers.platform import Platform
from platform_daemon.core.hardware.shot import RawShot, run_shot
from platform_daemon.core.jobs.jobs import Cancelled, Job, Work
from platform_daemon.core.recordings.calibrations import check_calibration_name
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.schemas.calibrations import CalibrationReport, ComplexTable
from platform_daemon.core.schemas.requests import CalibrationRequest
from sequences.compiler import TransmitSide
from sequences.tones import ToneShot, played_hz

log = structlog.get_logger()
PartT = TypeVar("PartT")
TRIES = 3  # per shot, if it is refused
DOUBTFUL_CHI2_PER_DOF = 2.0  # above it the model of the chain does not explain what was measured: a warning
QUESTION_STEP_S = 0.1

CalibrationJob = Job[CalibrationRequest, CalibrationReport | NoResult]


CalibrationWork = Work[CalibrationRequest, CalibrationReport | NoResult]


@dataclass
class CalibrationBench:
    """Platform, request, and where the file goes; frequencies_hz: (k,) rising, as the card plays them.

    Raises InputError if there are not two of them, or the name of the file is none.
    """

    platform: Platform
    request: CalibrationRequest
    side: TransmitSide
    folder: Path
    frequencies_hz: NDArray[np.float64] = field(init=False)
    _celsius: list[float] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        """See the class."""
        check_calibration_name(self.request.file_name)
        self.frequencies_hz = np.array(sorted({played_hz(f, self.side.card) for f in self.request.frequencies_hz}))
        if self.frequencies_hz.size < 2:
            raise InputError("two different frequencies are needed", where="frequencies_hz", remedy="give another one")

    @property
    def extent_hz(self) -> tuple[float, float]:
        """The lowest and the highest frequency."""
        return float(self.frequencies_hz[0]), float(self.frequencies_hz[-1])

    def shots(self, places: int) -> int:
        """How many shots so many directions or coils take, unless some must be repeated."""
        return places * self.frequencies_hz.size * self.request.repetitions

    def shots_s(self, shots: Sequence[ToneShot]) -> tuple[float, ...]:
        """How long they take at least, s, each with its repetitions."""
        return tuple(shot.timeline.duration_s for shot in shots for _ in range(self.request.repetitions))

    def place(self, job: CalibrationJob, done: Callable[[], bool], what: str) -> None:
        """Have something brought into place; wait for the operator unless the platform does it.  Raises Cancelled."""
        if done():
            return
        job.ask(what)
        while not job.proceed.wait(timeout=QUESTION_STEP_S):
            if job.cancel_requested.is_set():
                raise Cancelled
        job.answered()

    def shoot(self, job: CalibrationJob, shot: ToneShot, phase: str) -> RawShot:
        """One good shot.  Raises DeviceFault if it is refused again and again."""
        job.at(job.done, phase)
        for _ in range(TRIES):
            raw = run_shot(self.platform, shot, cancelled=job.cancel_requested.is_set)
            if raw.temperature_c is not None:
                self._celsius.append(raw.temperature_c)
            job.warnings += [text for text in raw.warnings if text not in job.warnings]
            if raw.reason is None:
                job.at(job.done + 1, phase)
                return raw
            job.warnings.append(f"{phase}: a shot was refused: {raw.reason}")
        remedy = "find the cause named; no calibration was written"
        raise DeviceFault(f"{TRIES} shots in a row were refused", why=str(raw.reason), remedy=remedy)

    def temperatures_c(self) -> tuple[float | None, tuple[float, float] | None]:
        """Mean temperature of the shots, and the range in which the calibration holds; None if it is not measured."""
        if not self._celsius:
            return None, None
        span = self.request.temperature_span_c
        return float(np.mean(self._celsius)), (min(self._celsius) - span, max(self._celsius) + span)


def ended(job: CalibrationJob, found: CalibrationReport) -> None:
    """Set the job's result, once the calibration is in its file, and log it."""
    job.result = found
    log.info("calibration_written", file=found.root.file)


def needed(part: PartT | None, what: str) -> PartT:
    """A part of the platform that not every one has.  Raises ConfigError."""
    if part is None:
        remedy = "describe it in the platform file, see docs/howto/calibration.md"
        raise ConfigError(f"the platform has no {what}", where=what.replace(" ", "_"), remedy=remedy)
    return part


def complex_table(value: NDArray[np.complex128], std: NDArray[np.float64]) -> ComplexTable:
    """A measured table (a, b, k) and the standard deviation of its real and imaginary parts, as JSON has it."""
    return ComplexTable(real=value.real.tolist(), imag=value.imag.tolist(), std=std.tolist())
