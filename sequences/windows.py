"""Window lengths in whole samples, and the realised frequency and times."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drivers.errors import SequenceRejected
from drivers.timeline import SampleClock
from sequences.request import SequenceRequest


def whole_steps(samples: float, step: int) -> int:
    """Samples rounded up to whole steps."""
    return step * math.ceil(samples / step)


@dataclass(frozen=True)
class Windows:
    """Samples per window and the excitation frequency, at the start of TX, that fits whole periods into them."""

    tx_samples: int
    switch_samples: int
    rx_samples: int
    frequency_hz: float


def realise(request: SequenceRequest, clock: SampleClock, step: int = 1) -> Windows:
    """Whole samples for the three windows, each a multiple of `step`, the card's grid of edges.

    The TX window holds a whole number of periods and of samples, so the frequency changes slightly: 10 periods of 212
    Hz at 125 MHz/2048 become 2879 samples and 212.0012 Hz.  Raises SequenceRejected for a frequency that the clock
    cannot play with at least 8 samples per period, or an RX window below one sample.
    """
    if request.f_tx_hz > clock.rate_hz / 8:
        raise SequenceRejected(
            f"{request.f_tx_hz:g} Hz is too high for a sampling rate of {clock.rate_hz:.1f} Hz",
            where="sequence.f_tx_hz",
            remedy=f"ask for at most {clock.rate_hz / 8:.0f} Hz",
        )
    mean_hz = request.f_tx_hz + 0.5 * request.chirp_hz
    tx = step * round(request.tx_periods * clock.rate_hz / mean_hz / step)
    rx = step * round(request.rx_s * clock.rate_hz / step)
    if rx < 1:
        raise SequenceRejected(
            f"an RX window of {request.rx_s:g} s holds no sample",
            where="sequence.rx_s",
            remedy=f"ask for at least {step / clock.rate_hz:.2g} s",
        )
    if tx < 8 * request.tx_periods:
        raise SequenceRejected(
            f"{request.tx_periods} periods of {request.f_tx_hz:g} Hz do not fit the card's steps of {step} samples",
            where="sequence.tx_periods",
            remedy="ask for more periods or a lower frequency",
        )
    played_hz = request.tx_periods * clock.rate_hz / tx - 0.5 * request.chirp_hz
    return Windows(tx, whole_steps(request.switch_s * clock.rate_hz, step), rx, played_hz)
