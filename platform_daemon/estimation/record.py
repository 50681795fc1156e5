"""The RX part of one shot, as the estimator takes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from .numerics.arrays import Array
from .sensitivity import inverse_sensitivity

Quantity = Literal["dmdt", "voltage", "angle"]


@dataclass(frozen=True)
class RingDownRecord:
    """Samples of one ring-down; sample 0 is the first RX sample, time 0.

    Attributes:
        samples: (channels, n) float64; A m^2/s for "dmdt" (channels = world x, y, z), V at the ADC for "voltage",
            rad for "angle" (one channel).
        sampling_rate_hz: samples per second.
        quantity: what the samples are.
        valid_from, valid_to: only samples in this half-open range are used (filter edges lie outside).
        full_scale: largest magnitude the digitiser can return, in the unit of the samples; None: unknown.
        sensitivity: P, (channels, 3) T/A, of volts that come from a flat chain; None: unknown.

    Raises:
        ValueError: complex samples, wrong shape, rate or range, singular sensitivity. Bad *values* (NaN, clipping) are
            judged by the fit instead.
    """

    samples: Array
    sampling_rate_hz: float
    quantity: Quantity
    valid_from: int = 0
    valid_to: int | None = None
    full_scale: float | None = None
    sensitivity: Array | None = None

    def __post_init__(self) -> None:
        if np.iscomplexobj(self.samples):
            raise ValueError("samples must be real, not complex: a part of them would be lost")
        samples = np.ascontiguousarray(self.samples, dtype=np.float64)
        object.__setattr__(self, "samples", samples)
        if samples.ndim != 2 or samples.shape[0] < 1:
            raise ValueError(f"samples must have shape (channels, n), not {samples.shape}")
        if self.quantity not in get_args(Quantity):
            raise ValueError(f"quantity must be one of {', '.join(get_args(Quantity))}, not {self.quantity!r}")
        if self.quantity == "dmdt" and samples.shape[0] != 3:
            raise ValueError(f"dm/dt has the three world components, not {samples.shape[0]} channels")
        if self.quantity == "angle" and samples.shape[0] != 1:
            raise ValueError(f"an angle is one channel, not {samples.shape[0]}")
        if self.sensitivity is not None:
            if self.quantity != "voltage":
                raise ValueError(f"a sensitivity belongs to volts, not to {self.quantity}")
            inverse_sensitivity(self.sensitivity, samples.shape[0])
        if not (np.isfinite(self.sampling_rate_hz) and self.sampling_rate_hz > 0.0):
            raise ValueError(f"sampling_rate_hz must be positive, not {self.sampling_rate_hz!r}")
        if not 0 <= self.valid_from <= self.end <= samples.shape[1]:
            raise ValueError(
                f"valid range {self.valid_from}..{self.end} does not lie in the {samples.shape[1]} samples"
            )

    @property
    def end(self) -> int:
        """First sample after the valid range."""
        return self.samples.shape[1] if self.valid_to is None else self.valid_to

    @property
    def dt_s(self) -> float:
        """Sampling interval in s."""
        return 1.0 / self.sampling_rate_hz

    @property
    def channels(self) -> int:
        """Number of channels."""
        return int(self.samples.shape[0])

    @property
    def valid(self) -> Array:
        """The valid samples, (channels, end - valid_from)."""
        return self.samples[:, self.valid_from : self.end]
