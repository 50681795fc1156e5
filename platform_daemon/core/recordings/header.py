"""What the engine hands to the store: plain values, no type of any device."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from platform_daemon.core.schemas.base import ClockKind
from platform_daemon.core.schemas.value_sources import ValueSource

from .recording import Excitation, SequenceInfo, StepLabel


@dataclass(frozen=True, eq=False)
class SeriesHeader:
    """What holds for every shot of a series.

    sequence: clock and windows; channels: rows of every shot's volts; start_time: ISO 8601 of the start of the series;
    clock: that its times go by, None: not known; calibration None: voltage-domain work only; excitation None: unknown
    (a shot may bring its own); planned_shots None: open end; channel_names: () or one per channel; devices: role
    ("io_card", ...) to identity; value_sources: where the values of its sequence come from; texts may be "".
    """

    sequence: SequenceInfo
    channels: int
    start_time: str
    software_version: str
    variant: str | None = None
    calibration: ReceiveCalibration | None = None
    excitation: Excitation | None = None
    planned_shots: int | None = None
    title: str = ""
    sample_name: str = ""
    operator: str = ""
    comment: str = ""
    platform: str = ""
    configuration_toml: str = ""
    channel_names: tuple[str, ...] = ()
    devices: Mapping[str, str] = field(default_factory=dict)
    value_sources: tuple[ValueSource, ...] = ()
    clock: ClockKind | None = None


@dataclass(frozen=True, eq=False)
class ShotRecord:
    """One shot as it came from the hardware.

    volts: (c, n) V at the ADC input, kept as float32.  A good shot has exactly `sequence.total` finite samples; a
    refused one may have fewer (also none), the rest is then padded with zeros and `valid_samples` says so.
    time_stamp: ISO 8601 and monotonic_s: host clock, both of the trigger; verdict: "good" or "refused" with a reason;
    the flags are the I/O card's (overwritten, corrupted, lost_steps), the LNA's and the amplifier's; blank: no
    excitation; excitation None: the header's (of a blank shot, with field and current zero);
    truth: what a simulator knows, anything JSON can say, None on real hardware; step: of a procedure, None: none;
    joined: the first one after the series had been cut off and was resumed; late_s: from when it was due to its
    trigger, None: unknown.
    """

    volts: NDArray[Any]
    time_stamp: str
    monotonic_s: float
    verdict: str = "good"
    reason: str = ""
    temperature_c: float | None = None
    overwritten: bool = False
    corrupted: bool = False
    lost_steps: bool = False
    lna_overload: bool = False
    amplifier_clipped: bool = False
    blank: bool = False
    excitation: Excitation | None = None
    truth: Mapping[str, Any] | None = None
    step: StepLabel | None = None
    joined: bool = False
    late_s: float | None = None


@dataclass(frozen=True, eq=False)
class FitTable:
    """Fit results of a series under one window and model, one row per frame.

    name: of the group under `/fit`, e.g. "d30"; parameters: (k,) names with units in them, as in `fit --json`;
    values and std: (frame, k), std NaN where a parameter was fixed; covariance: (frame, k, k); r2, nrmse, chi2_per_dof,
    window_s: (frame,); correction: how one angle was corrected for an adopted manufacturing error, as JSON, or "";
    verdict ("good", "refused" or "blank") and reason: one per frame.  Rows that are not good are
    NaN.
    """

    name: str
    parameters: tuple[str, ...]
    values: NDArray[np.float64]
    std: NDArray[np.float64]
    covariance: NDArray[np.float64]
    r2: NDArray[np.float64]
    nrmse: NDArray[np.float64]
    chi2_per_dof: NDArray[np.float64]
    window_s: NDArray[np.float64]
    verdict: tuple[str, ...]
    reason: tuple[str, ...]
    variant: str = ""
    software_version: str = ""
    correction: str = ""
