"""Content of a recording file as frozen values; volts are read frame by frame on request."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from drivers.errors import InputError
from platform_daemon.core.schemas.base import ClockKind
from platform_daemon.core.schemas.value_sources import ValueSource

from .checks import check_calibration, no_calibration_for_counts
from .hdf5 import open_hdf5
from .layout import CONFIGURATION, DATA, FLAGS

RESONATOR = "\n# resonator\n"
"""Between the configuration of the platform and the declaration of the resonator."""


@dataclass(frozen=True)
class SequenceInfo:
    """Sample clock and windows of every frame: TX, then switch, then RX (paper, section "Measurement Sequence")."""

    base_frequency_hz: float
    decimation: int
    tx_samples: int
    switch_samples: int
    rx_samples: int

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self.base_frequency_hz / self.decimation

    @property
    def rx_start(self) -> int:
        """Index of the first RX sample, the time zero of every fit."""
        return self.tx_samples + self.switch_samples

    @property
    def total(self) -> int:
        """Samples in a whole frame."""
        return self.rx_start + self.rx_samples


@dataclass(frozen=True, eq=False)
class Excitation:
    """What one shot was excited with.

    field_t: peak of the commanded field at the rotor, T; axis: (3,) unit vector of that field in world axes;
    requested_hz and realised_hz differ because whole periods must fit whole samples; current_a: (outputs,) commanded
    peak coil currents, A; phase_rad: of the sine at the first TX sample.
    """

    waveform: str
    requested_hz: float
    realised_hz: float
    field_t: float
    axis: NDArray[np.float64]
    periods: float
    phase_rad: float
    current_a: NDArray[np.float64]


@dataclass(frozen=True)
class StepLabel:
    """Which step of a procedure a shot belongs to: number from 1, what the step was made with, by key, and its name,
    as tune or series; "": it has none."""

    number: int
    values: Mapping[str, float | str]
    name: str = ""


@dataclass(frozen=True)
class FrameStep:
    """The step of a stored frame, and the frame's own windows, samples: steps may differ in them.

    Where a window is shorter than the recording's, zeros stand before TX and behind RX, so that the RX windows of all
    frames begin at the same sample.
    """

    label: StepLabel
    tx_samples: int
    switch_samples: int
    rx_samples: int


@dataclass(frozen=True, eq=False)
class FrameInfo:
    """One frame's own record.  A file from elsewhere says nothing: every frame is then "good" and whole.

    shot: number in the series from 1; time_stamp: ISO 8601; monotonic_s: the host's monotonic clock; valid_samples:
    the samples behind it are zero padding (only ever less than a whole frame when the verdict is "refused", or when
    other steps of the same procedure have longer windows); step: None outside of procedures; joined: the first
    shot after the series had been cut off and was resumed; late_s: from when it was due to its trigger.
    """

    shot: int
    valid_samples: int
    verdict: str = "good"
    reason: str = ""
    time_stamp: str | None = None
    monotonic_s: float | None = None
    temperature_c: float | None = None
    overwritten: bool = False
    corrupted: bool = False
    lost_steps: bool = False
    lna_overload: bool = False
    amplifier_clipped: bool = False
    blank: bool = False
    excitation: Excitation | None = None
    step: FrameStep | None = None
    joined: bool = False
    late_s: float | None = None

    @property
    def flags(self) -> tuple[str, ...]:
        """Names of the flags that are set."""
        return tuple(name for name in FLAGS if getattr(self, name))


@dataclass(frozen=True)
class Provenance:
    """Who recorded what with which hardware and software; only our own files carry it.

    incomplete: None, or why the series has fewer shots than planned; devices: device role to identity; value_sources:
    where the values of the sequence come from, of a procedure those of its last step, which sources_step numbers; ():
    the file does not say; clock: that its times go by, None: the file does not say.
    """

    series_id: str
    title: str
    start_time: str
    sample_name: str
    operator: str
    comment: str
    platform: str
    software_version: str
    channel_names: tuple[str, ...]
    devices: Mapping[str, str]
    planned_shots: int | None
    incomplete: str | None
    value_sources: tuple[ValueSource, ...] = ()
    sources_step: int | None = None
    clock: ClockKind | None = None


@dataclass(frozen=True, eq=False)
class Recording:
    """A checked recording.  Holds no open file: every read opens the file again, so it may cross threads freely.

    calibration None: only voltage-domain work is possible; variant None: the caller must name it; provenance None: not
    one of our own files; fits: names under `/fit`; lna_gain: at which it was recorded, V/V, None: not said; counts: the
    samples are integers of a converter, and whatever is in V here is in counts; other_layout: what a reader must know
    of a layout that this version does not know, or of times that were sorted; "": nothing.
    """

    path: Path
    sequence: SequenceInfo
    frames: int
    channels: int
    frame_info: tuple[FrameInfo, ...]
    calibration: ReceiveCalibration | None = None
    variant: str | None = None
    provenance: Provenance | None = None
    fits: tuple[str, ...] = ()
    size_bytes: int = 0
    lna_gain: float | None = None
    counts: bool = False
    other_layout: str = ""

    def frame_volts(self, k: int) -> NDArray[np.float64]:
        """Frame `k` from 0, whole: (c, n) float64, V at the ADC input.

        Raises InputError for a frame that does not exist, RecordingError for a sample that is not finite or a file
        that changed or broke since it was opened.
        """
        if not 0 <= k < self.frames:
            raise InputError(
                f"frame {k} does not exist", where=str(self.path), remedy=f"frames go from 0 to {self.frames - 1}"
            )
        with open_hdf5(self.path) as source:
            return source.frame(DATA, k, (self.frames, self.channels, self.sequence.total), "" if self.counts else "V")

    def rx_volts(self, k: int) -> NDArray[np.float64]:
        """The RX window of frame `k`: (c, rx_samples) float64, V; of a step with a shorter one its own samples only.

        The whole frame is checked; errors as above.
        """
        volts, step = self.frame_volts(k)[:, self.sequence.rx_start :], self.frame_info[k].step
        return volts if step is None else volts[:, : step.rx_samples]

    @property
    def content_key(self) -> tuple[object, ...]:
        """Another one as soon as the content has changed, for what is kept of it.  Raises OSError."""
        stat = self.path.stat()
        return self.path, stat.st_mtime_ns, stat.st_size

    def configuration_toml(self) -> str:
        """The configuration as text, "" if the file has none; read only here.

        On a simulated platform it names the seed and the effects, which nothing that estimates or diagnoses may see.
        Raises RecordingError.
        """
        with open_hdf5(self.path) as source:
            return source.text(CONFIGURATION) or ""

    def resonator_toml(self) -> str:
        """The part of the configuration that declares the resonator, "" without one.  Raises RecordingError."""
        _, found, text = self.configuration_toml().rpartition(RESONATOR)
        return text if found else ""

    def with_calibration(self, calibration: ReceiveCalibration, source: str = "calibration") -> Recording:
        """The same recording under another calibration, which came from `source`; RecordingError if it does not fit."""
        if self.counts:
            raise no_calibration_for_counts(f"{self.path}:{DATA}")
        check_calibration(calibration, self.channels, f"{source} (used for {self.path})")
        return replace(self, calibration=calibration)
