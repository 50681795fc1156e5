"""Contract of the temperature sensor at the resonator, and how much a reading of it may decide: nothing.

The temperature is looked at; the voltages are measured.  So a thermometer that fails, or does not answer, keeps neither
a platform from being opened nor a shot from being stored.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Protocol

from drivers.errors import DeviceError, DeviceLost, DeviceProtocolError

PLAUSIBLE_C = (-40.0, 80.0)
"""Readings outside are no temperature of a resonator: 85 is what a DS18B20 says after power-on, -127 and -999 stand for
a sensor that is missing, 9.9E37 is the NaN of SCPI."""
_AGAIN_S = 10.0
"""One that did not answer is not asked again before, because each question costs its time-out between two shots."""


class Thermometer(Protocol):
    """Temperature at the resonator."""

    def temperature_c(self) -> float:
        """Latest reading, deg C.  Raises DeviceTimeout."""

    def close(self) -> None:
        """Let go.  Idempotent."""


def plausible_temperature_c(thermometer: Thermometer) -> float:
    """A reading, deg C, that can be a temperature.  Raises DeviceError; DeviceProtocolError for one that cannot."""
    reading = thermometer.temperature_c()
    low, high = PLAUSIBLE_C
    if not (math.isfinite(reading) and low <= reading <= high):
        raise DeviceProtocolError(
            f"a reading of {reading:g} degC is no temperature of a resonator",
            where="thermometer",
            why=f"it is not between {low:g} and {high:g} degC; some sensors report a missing probe by such a number",
            remedy="check the probe and its cable",
        )
    return reading


class RetriedThermometer:
    """A thermometer that may be missing at first, and after it has failed: it is opened when it is there again."""

    def __init__(self, open_it: Callable[[], Thermometer], now_s: Callable[[], float] = time.monotonic) -> None:
        """Open it; one that does not open raises nothing here.  Raises ConfigError."""
        self._open, self._now_s = open_it, now_s
        self._opened: Thermometer | None = None
        self._failed_s = -math.inf
        self._error: DeviceError = DeviceLost("the thermometer is closed", where="thermometer")
        self._closed = False
        try:
            self._opened = open_it()
        except DeviceError as error:
            self._fail(error)

    def temperature_c(self) -> float:
        """See Thermometer.  Raises DeviceError; the last one again without a question if it is younger than 10 s."""
        if self._closed or self._now_s() - self._failed_s < _AGAIN_S:
            raise self._error
        try:
            if self._opened is None:
                self._opened = self._open()
            return self._opened.temperature_c()
        except DeviceProtocolError:  # it has answered, so the next question costs no time-out
            raise
        except DeviceError as error:
            self._fail(error)
            raise

    def close(self) -> None:
        """See Thermometer."""
        self._closed = True
        if self._opened is not None:
            self._opened.close()

    def _fail(self, error: DeviceError) -> None:
        self._error, self._failed_s = error, self._now_s()
