"""A frame as fits take it, and what is refused before anything is fitted, in the words of a fit's refusals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from drivers.errors import PlatformError, RecordingError
from platform_daemon.core.state.errors import NotFinite
from platform_daemon.estimation.calibration.apply import calibrate
from platform_daemon.estimation.calibration.receiver_correction import correct_receiver_effects
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.screening.clipping import Clipping, find_clipping
from platform_daemon.estimation.sensitivity import CalibrationError

_STOPPED_SHARE = 0.01
"""Of the samples: how many at the end may be equal in all channels before this is told.

Noise of a standard deviation of 0.3 codes, in the middle of a code, stays in it with a probability of 0.904; in three
channels for 1 % of 10^4 samples that is 0.904^300 = 7e-14.  A shorter end would be told of quiet recordings that are
whole, a longer one loses as much of the window.
"""


@dataclass(frozen=True, eq=False)
class FrameSignal:
    """One frame as a fit takes it.

    Attributes:
        record: dm/dt (3, n) A m^2/s, volts (c, n), or an angle (1, n) rad.
        raw: volts (c, n) as the converter gave them; None: no converter is known, as for an angle.
        notes: what had to be assumed, or what is wrong with the clock.
    """

    record: RingDownRecord
    raw: NDArray[np.float64] | None
    notes: tuple[str, ...] = ()

    def clipping(self) -> Clipping | None:
        """Clipping of the raw volts, whatever a calibration mixes afterwards; None without."""
        return None if self.raw is None else find_clipping(self.raw)

    def harmless_clipping(self) -> Clipping | None:
        """Clipping that does no harm, None without.  Raises RefusedError if it would spoil the result."""
        clipped = self.clipping()
        if clipped is not None and clipped.severe:
            raise RefusedError(Refusal.SATURATED, str(clipped))
        return clipped

    def refuse_nothing(self) -> None:
        """Raises RefusedError if all channels have one value in all samples, as what was never written has."""
        if self.raw is not None and self.raw.size and not np.ptp(self.raw, axis=1).any():
            what = f"every sample of every channel is {self.raw[0, 0]:.6g} V: nothing was recorded"
            remedy = "the place of a shot that was not made, or a converter that was not read; leave the frame out"
            raise RefusedError(Refusal.NO_SIGNAL, what, remedy)

    def without_a_reading(self) -> tuple[str, ...]:
        """A warning for each channel that has one value in all samples, as one that nothing was read from has."""
        if self.raw is None:
            return ()
        silent = tuple(
            f"silent_channel: every sample of channel {channel} is {y[0]:.6g} V, without any noise: was it connected, "
            "or was a channel that was not measured filled up? The fit has taken it for a measured one"
            for channel, y in enumerate(self.raw)
            if y.size and y.min() == y.max()
        )
        n = self.raw.shape[1]
        changes = np.flatnonzero((self.raw != self.raw[:, -1:]).any(axis=0))
        same = n - 1 - int(changes[-1]) if len(changes) else 0
        if same <= _STOPPED_SHARE * n:
            return silent
        said = (
            f"stopped: the last {same} of {n} samples do not change in any channel: where the recording ended early, "
            "nothing was measured there; fit a window that ends before"
        )
        return (*silent, said)


def reason_of(error: PlatformError) -> str:
    """Why a frame that cannot be read is refused."""
    return str(RefusedError(Refusal.NOT_FINITE, error.seen)) if isinstance(error, NotFinite) else str(error)


def calibrated_signal(
    rx_volts: NDArray[np.float64], rate_hz: float, calibration: ReceiveCalibration | None
) -> FrameSignal:
    """The RX window of a frame, (c, n) V: calibrated dm/dt, or volts as they are if there is no calibration.

    Raises RecordingError if the calibration does not fit the data.
    """
    if calibration is None:
        return FrameSignal(RingDownRecord(rx_volts, rate_hz, "voltage"), rx_volts)
    try:
        done = calibrate(
            rx_volts, rate_hz, calibration.sensitivity, calibration.frequency_hz, calibration.frequency_response
        )
    except CalibrationError as error:
        where = f"calibration {calibration.identifier or 'of the file'}"
        raise RecordingError(str(error), where=where, remedy="calibrate again, or give another calibration") from None
    record = RingDownRecord(done.dmdt, rate_hz, "dmdt", valid_from=done.valid_from, valid_to=done.valid_to)
    corrected = correct_receiver_effects(record, calibration.sensitivity, calibration.receiver)
    return FrameSignal(corrected, rx_volts, tuple(done.notes))
