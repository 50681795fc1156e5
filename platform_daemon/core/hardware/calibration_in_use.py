"""Another calibration for a daemon that runs: read, checked against the platform, and in use from the next series on.

Only a command does that: a calibration job or a file that was replaced changes nothing by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import structlog

from drivers.calibration import ReceiveCalibration, TransmitCalibration
from drivers.errors import ConfigError, InputError, RecordingError
from drivers.platform import Platform
from drivers.registry import check_gain
from platform_daemon.core.recordings.calibrations import read_transmit_calibration
from platform_daemon.core.recordings.reader import read_calibration
from platform_daemon.core.schemas.calibrations import CalibrationName, CalibrationsInUse
from platform_daemon.core.schemas.requests import ActivationRequest
from sequences.compiler import TransmitSide
from sequences.limits import SafetyLimits

log = structlog.get_logger()


@dataclass(frozen=True)
class CalibrationFiles:
    """The files that the platform file names; None: it names none."""

    receive: Path | None = None
    transmit: Path | None = None

    def requested_file(self, request: ActivationRequest, folder: Path) -> Path:
        """The file of a request; calibrations made by jobs are in `folder`.  Raises InputError."""
        if request.calibration is not None:
            return folder / f"{request.calibration}.h5"
        named = self.receive if request.kind == "receive" else self.transmit
        if named is None:
            raise InputError(
                f"the platform file names no file of a {request.kind} calibration",
                where="calibration",
                remedy="give the name of a calibration that a job has written",
            )
        return named


def read_receive(path: Path) -> ReceiveCalibration:
    """The receive calibration in a calibration file or a recording.  Raises RecordingError."""
    c = read_calibration(path)
    if c.identifier is None or c.date is None:
        remedy = "add /calibration/identifier and /calibration/date to the file"
        raise RecordingError("the calibration has no name or date", where=str(path), remedy=remedy)
    return replace(c, transmit=None)


def read_either(kind: str, path: Path) -> ReceiveCalibration | TransmitCalibration:
    """The calibration of that kind in a file.  Raises RecordingError."""
    return read_receive(path) if kind == "receive" else read_transmit_calibration(path)


class ChainTest(Protocol):
    """Tests the measuring chain before a series; a feature makes it."""

    enabled: bool

    def __call__(self, cancelled: Callable[[], bool] = lambda: False) -> Any:
        """Make the test; what was measured, None if it is switched off.  Raises DeviceFault that says what is wrong,
        Cancelled."""


class MakeChainTest(Protocol):
    """Makes the test for a transmit side."""

    def __call__(self, side: TransmitSide, *, enabled: bool | None = None) -> ChainTest:
        """enabled: in place of the platform file's.  Raises SequenceRejected if the test leaves the limits."""


class NoChainTest:
    """For platforms without a test."""

    enabled = False

    def __init__(self, side: TransmitSide, *, enabled: bool | None = None) -> None:
        """See MakeChainTest."""

    def __call__(self, cancelled: Callable[[], bool] = lambda: False) -> None:
        """See ChainTest."""


class CalibrationInUse:
    """What a job is made from: the transmit side, the chain test, and the platform's calibrations.

    Raises SequenceRejected if the chain test leaves the limits.
    """

    def __init__(
        self, platform: Platform, limits: SafetyLimits, make_chain_test: MakeChainTest, files: CalibrationFiles
    ) -> None:
        self._platform, self._files = platform, files
        self._make_chain_test = make_chain_test
        self.side = TransmitSide(
            platform.transmit,
            platform.card.capabilities(),
            platform.switch.timing(),
            limits,
            platform.amplifier_off_s,
        )
        self.chain_test = make_chain_test(self.side)

    def activate(self, request: ActivationRequest, folder: Path) -> None:
        """Use another calibration from now on; no job may be under way.

        Raises InputError, also as RecordingError, ConfigError or SequenceRejected; then all stays as it was.
        """
        found = read_either(request.kind, self._files.requested_file(request, folder))
        if isinstance(found, TransmitCalibration):
            channels = found.applied(self._platform.transmit)
            side = replace(self.side, channels=channels)
            self.chain_test = self._make_chain_test(side)
            self.side, self._platform.transmit, self._platform.transmit_calibration = side, channels, found
        else:
            _check(found, self._platform)
            self._platform.calibration = found
        log.info("calibration_adopted", calibration=found.identifier, date=found.date)

    def make_chain_test(self, *, enabled: bool | None = None) -> ChainTest:
        """The test for the transmit side of now; enabled: in place of the platform file's.  Raises SequenceRejected."""
        return self._make_chain_test(self.side, enabled=enabled)

    def in_use(self) -> CalibrationsInUse:
        """Name and date of both calibrations."""
        receive, transmit = self._platform.calibration, self._platform.transmit_calibration
        return CalibrationsInUse(
            calibration=_named(receive), transmit_calibration=None if transmit is None else _named(transmit)
        )


def _check(found: ReceiveCalibration, platform: Platform) -> None:
    """Raises ConfigError if it is not one of this platform."""
    check_gain(found, platform.lna.gain())
    has, needs = len(found.sensitivity), len(platform.calibration.sensitivity)
    if has != needs:
        raise ConfigError(
            f"the calibration has {has} channels, the platform {needs}",
            where="calibration",
            why=f"it is {found.identifier!r}",
            remedy="name a calibration of this platform",
        )


def _named(calibration: ReceiveCalibration | TransmitCalibration) -> CalibrationName:
    return CalibrationName(id=calibration.identifier or "", date=calibration.date or "")
