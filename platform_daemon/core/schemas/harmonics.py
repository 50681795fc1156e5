"""What the harmonics of one shot tell, at constant cost: for live display and as a cross-check of the fit."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from .base import Absent, Root, Schema, Vector, example
from .fits import FileError


class _Shot(Schema):
    recording: Absent[str] = None
    """Id of the recording, for a stored frame by REST; else missing."""
    acquisition: Absent[str] = None
    """Id of the acquisition, for the last shot of one that may still run; else missing."""
    frame: Absent[int] = None
    """Number of a stored frame, from 0; else missing."""
    shot: Absent[int] = None
    """Number of the shot in its acquisition, from 1; missing for a stored frame."""


class HarmonicEstimate(_Shot):
    """Frequency, amplitude, moment, orientation and decay in the first 24 periods; no errors are given."""

    model_config = ConfigDict(json_schema_extra=example("harmonic_estimate"))

    verdict: Literal["good"]
    """The harmonics can be read."""
    reason: None
    """null."""
    time_s: float
    """Middle of the stretch that was looked at, s after the first RX sample."""
    stretch_s: float
    """Its length, s."""
    frequency_hz: float
    """Frequency of the motion there, Hz."""
    chirp_hz_per_s: float
    """How fast it rises as the amplitude falls, Hz/s."""
    f_nat_hz: float
    """Natural frequency, Hz."""
    m_r_am2: float
    """Magnetic moment of the rotor, A m^2."""
    amplitude_rad: float
    """Amplitude of the swing at time_s, rad."""
    amplitude_at_start_rad: float
    """The same carried back to the first RX sample along a straight line, rad."""
    decay_per_s: float
    """-d ln sin(A/2)/dt, 1/s."""
    lambda_per_s: float
    """Viscous damping that alone would explain the decay, 1/s."""
    rodrigues_rad: Vector
    """Orientation as a rotation vector, rad."""
    harmonics_am2_per_s: tuple[float, ...]
    """Amplitudes of harmonics 1 to 4 of dm/dt over all channels, A m^2/s, (4,)."""
    second_harmonic_snr: float
    """Amplitude of the second harmonic over the noise between the harmonics, 1."""


class RefusedHarmonicEstimate(_Shot):
    """The harmonics cannot be read."""

    model_config = ConfigDict(json_schema_extra=example("refused_harmonic_estimate"))

    verdict: Literal["refused", "blank"]
    """There are no numbers; blank: the shot was made without excitation."""
    reason: str
    """Why."""


AnyHarmonicEstimate = Annotated[HarmonicEstimate | RefusedHarmonicEstimate, Field(discriminator="verdict")]


class HarmonicsReport(Schema):
    """What the harmonics of the frames of one file tell."""

    model_config = ConfigDict(json_schema_extra=example("harmonics_report"))

    file: str
    """Path as it was named."""
    calibration: str | None
    """Identifier of the receive calibration; null: the file has none."""
    frames: tuple[AnyHarmonicEstimate, ...]
    """Frame by frame."""


class HarmonicsBatch(Schema):
    """The same of several files, in the order in which they were named."""

    model_config = ConfigDict(json_schema_extra=example("harmonics_batch"))

    files: tuple[HarmonicsReport | FileError, ...]
    """One entry per file."""


class ShotHarmonics(Root[AnyHarmonicEstimate]):
    """What the harmonics of one shot tell, or why they cannot be read."""

    model_config = ConfigDict(json_schema_extra=example("harmonic_estimate", "refused_harmonic_estimate"))
