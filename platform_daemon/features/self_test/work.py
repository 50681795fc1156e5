"""The self-test, before a series and as a job: a weak tone per coil, measured by the leakage of the receive contacts.

While a coil is driven the receiver is disconnected, but the isolation of a switch is finite, some 80 dB: what leaks
into the coil's own channel passes every cable of the chain but those to the coil itself
(docs/decisions/0010-the-self-test-listens-to-leakage.md).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import structlog
from numpy.typing import NDArray

from drivers.clock import SystemClock
from drivers.errors import DeviceFault, InterlockError
from drivers.platform import Platform
from platform_daemon.core.hardware.shot import RawShot, run_shot
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.schemas.requests import SelfTestOptions
from platform_daemon.core.service.bench import HardwareBench
from sequences.compiler import TransmitSide
from sequences.tones import coil_drive, coil_tones, played_hz

from .schema import SelfTestReport, SelfTestRequest

log = structlog.get_logger()

SEGMENTS = 4  # of a tone
SKIPPED_S = 1e-3  # at its start
SURE = 5.0  # standard deviations
CONNECTED = 10.0  # times the expected leakage: then it is no leakage


class SelfTestFailed(DeviceFault):
    """The chain is not as the platform file says; nothing may be measured with it."""

    title = "Self-test failed"


class SelfTest:
    """The self-test of one platform.  Checked when it is made: raises SequenceRejected."""

    def __init__(self, platform: Platform, side: TransmitSide, options: SelfTestOptions) -> None:
        self._platform, self._side, self._options = platform, side, options
        on = isinstance(platform.clock, SystemClock) if options.enabled is None else options.enabled
        self.enabled = on
        if on:
            drives = [coil_drive(c, options.amplifier_v, self.frequency_hz) for c in side.channels]
            self._shot, self._spans = coil_tones(drives, self.frequency_hz, options.tone_s, side)

    @property
    def coils(self) -> tuple[str, ...]:
        """The coils that are driven, by their axes."""
        return tuple(channel.axis for channel in self._side.channels)

    @property
    def frequency_hz(self) -> float:
        """Frequency of the tones as the card plays them, Hz."""
        return played_hz(self._options.frequency_hz, self._side.card)

    def __call__(self, cancelled: Callable[[], bool] = lambda: False) -> SelfTestReport | None:
        """Make the shot and return what was measured, None if the self-test is off.

        Raises SelfTestFailed that says what is wrong, Cancelled, DeviceError if a device fails otherwise.
        """
        if not self.enabled:
            return None
        raw = self._played(cancelled)
        if raw.reason is not None:  # says nothing of the wiring, so that it may be tried again
            log.warning("self_test_repeated", reason=raw.reason)
            raw = self._played(cancelled)
        if raw.reason is not None:
            raise _failed([raw.reason])
        heard, std = self._heard(raw.volts.astype(np.float64))
        own, sign = self._channels()
        expected = self._expected(heard, own)
        complaints = [c for k in range(len(own)) for c in self._complaints(k, heard, std, own, sign, expected)]
        if complaints:
            raise _failed(complaints)
        report = self._report(heard, own, expected)
        log.info("self_test_passed", **report.model_dump())
        return report

    def _played(self, cancelled: Callable[[], bool]) -> RawShot:
        """Make the shot.  Raises SelfTestFailed for a stuck switch, else what run_shot raises."""
        try:
            return run_shot(self._platform, self._shot, cancelled=cancelled)
        except (DeviceFault, InterlockError) as error:
            if error.where == "tx_rx_switch":
                raise _failed([f"the Tx/Rx switch is stuck: {error.what}"]) from None
            raise

    def _heard(self, volts: NDArray[np.float64]) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
        """Phasor of every coil's tone in every channel per volt at its DAC output, (channel, coil), and its std."""
        from platform_daemon.estimation.calibration.phasors import combine, segment_phasors

        rate_hz = self._shot.timeline.clock.rate_hz
        skipped = round(SKIPPED_S * rate_hz)
        value, std = [], []
        for burst, (first, last) in zip(self._shot.timeline.bursts, self._spans, strict=True):
            part = volts[:, first + skipped : last]
            found = combine(segment_phasors(part, self.frequency_hz, rate_hz, skipped, SEGMENTS))
            value.append(found.value / burst.amplitude_v / self._response())
            std.append(found.std / burst.amplitude_v)
        return np.array(value).T, np.array(std).T

    def _response(self) -> NDArray[np.complex128]:
        """What the receive chain does to the tone, by its calibration: (channel,)."""
        c = self._platform.calibration
        if c.frequency_hz is None or c.frequency_response is None:
            return np.ones(len(c.sensitivity), dtype=np.complex128)
        rows = [np.interp(self.frequency_hz, c.frequency_hz, row) for row in c.frequency_response]
        return np.array(rows, dtype=np.complex128)

    def _channels(self) -> tuple[list[int], list[float]]:
        """Which receive channel hangs on each coil, and with which sign, by the calibration."""
        fields = np.stack([c.field_per_ampere_t for c in self._side.channels], axis=1)
        projected = self._platform.calibration.sensitivity @ fields
        own = [int(np.argmax(np.abs(column))) for column in projected.T]
        return own, [float(np.sign(projected[c, k])) for k, c in enumerate(own)]

    def _expected(self, heard: NDArray[np.complex128], own: list[int]) -> NDArray[np.float64]:
        """Leakage per volt at the DAC, (coil,): from the declared isolation, else the median of the measured ones."""
        gains = np.array([c.amplifier_gain for c in self._side.channels])
        if self._options.isolation_db is not None:
            return np.asarray(gains * 10 ** (-self._options.isolation_db / 20) * self._platform.lna.gain())
        loudest = np.max(np.abs(heard), axis=0) / gains
        return np.asarray(gains * float(np.median(loudest)))

    def _complaints(
        self,
        k: int,
        heard: NDArray[np.complex128],
        std: NDArray[np.float64],
        own: list[int],
        sign: list[float],
        expected: NDArray[np.float64],
    ) -> list[str]:
        """What is wrong with the tone of coil k."""
        channels = self._side.channels
        me, output = channels[k].axis, channels[k].output
        loud = int(np.argmax(np.abs(heard[:, k])))
        gain = abs(heard[loud, k]) / expected[k]
        if SURE * std[own[k], k] > expected[k]:
            return [f"the tone of coil {me} is lost in noise: raise self_test.amplifier_v"]
        if abs(heard[loud, k]) < SURE * std[loud, k] or gain < 0.05:
            return [f"nothing is heard of output {output}: cable of coil {me} open, or its amplifier channel dead"]
        if gain > CONNECTED:
            return [f"coil {me} is heard {gain:.0f} times as loud as expected: the receiver is connected while"
                    " transmitting, the Tx/Rx switch is stuck on receive"]  # fmt: skip
        found = []
        if loud != own[k]:
            other = next((channels[j].axis for j, c in enumerate(own) if c == loud), str(loud))
            found.append(f"coil {other} is connected to output {output}, which is that of coil {me}")
        whose = own.index(loud) if loud in own else k
        if heard[loud, k].real * sign[whose] < 0:
            found.append(f"the polarity of {channels[whose].axis} is inverted")
        if abs(gain - 1) > max(self._options.tolerance, SURE * std[loud, k] / expected[k]):
            found.append(f"the gain of {channels[whose].axis} is {gain:.2g} of expected")
        return found

    def _report(self, heard: NDArray[np.complex128], own: list[int], expected: NDArray[np.float64]) -> SelfTestReport:
        """Gain of each coil relative to what is expected, and the isolation seen."""
        own_heard = np.array([abs(heard[c, k]) for k, c in enumerate(own)])
        gains = np.array([c.amplifier_gain for c in self._side.channels]) * self._platform.lna.gain()
        axes = self.coils
        return SelfTestReport(
            frequency_hz=self.frequency_hz,
            gain=dict(zip(axes, (own_heard / expected).tolist(), strict=True)),
            isolation_db=dict(zip(axes, (-20 * np.log10(own_heard / gains)).tolist(), strict=True)),
            date=self._platform.clock.utc().isoformat(timespec="seconds"),
        )


def _failed(complaints: list[str]) -> SelfTestFailed:
    remedy = "correct the wiring or the platform file; [self_test] enabled = false measures without the test"
    return SelfTestFailed("the self-test refuses the series", why="; ".join(complaints), remedy=remedy)


SelfTestJob = Job[SelfTestRequest, SelfTestReport | NoResult]


class SelfTestWork:
    """The self-test as a job; it is made even where the platform file switches it off before series.

    make: makes the test of the platform as it is when the job begins.  Raises SequenceRejected, at once, if the test
    would leave the limits.
    """

    kind, unit, total, no_result, duration_s = "self_test", "shots", 1.0, NoResult(), None

    def __init__(self, request: SelfTestRequest, make: Callable[[], Callable[..., SelfTestReport | None]]) -> None:
        self.request, self._make = request, make
        make()

    def __call__(self, job: SelfTestJob) -> None:
        """Raises SelfTestFailed that says what is wrong, Cancelled, DeviceError."""
        job.at(0, "self-test")
        found = self._make()(job.cancel_requested.is_set)
        assert found is not None
        job.result = found
        job.at(1, "done")


def plan(bench: HardwareBench, request: SelfTestRequest) -> SelfTestWork:
    """The checked work of a self-test; nothing moves.  Raises SequenceRejected."""
    return SelfTestWork(request, lambda: bench.engine.calibration_in_use.make_chain_test(enabled=True))


def chain_test(
    platform: Platform, options: SelfTestOptions, side: TransmitSide, *, enabled: bool | None = None
) -> SelfTest:
    """The test of the chain that comes before series and transmit calibrations.

    enabled: in place of that of the platform file.  Raises SequenceRejected if it would leave the limits.
    """
    if enabled is not None:
        options = options.model_copy(update={"enabled": enabled})
    return SelfTest(platform, side, options)
