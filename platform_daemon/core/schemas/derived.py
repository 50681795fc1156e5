"""What follows from the fits of a series: quality factors, envelopes, orientation errors, Allan deviation."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict
from typing_extensions import TypeAliasType

from .base import Schema, Vector, example

FrequencyNoise = TypeAliasType(
    "FrequencyNoise", Literal["white_phase", "flicker_phase", "white", "flicker", "random_walk"]
)
"""Power law of the noise of a frequency."""


class FrameQuantities(Schema):
    """Quality factors of one good frame."""

    quality_factor: float | None
    """Q of the viscous losses alone, 1; null where there are none."""
    equivalent_quality_factor: float | None
    """Q of a viscous damping that loses as much over the window, 1; null: the motion does not decay."""
    equivalent_quality_factor_to_infinity: float | None
    """The same until the motion has died, 1."""


class OrientationDeviation(Schema):
    """Angles between the orientations of a series and one of reference."""

    reference_rodrigues_rad: Vector
    """Rotation vector of the reference, rad."""
    angle_rad: tuple[float, ...]
    """Angle of every frame to it, of the nearer mirror solution, rad, (frames,)."""
    mean_rad: float
    """Mean of the angles, rad."""
    std_rad: float | None
    """Their standard deviation, rad; null where it is not finite."""


class OrientationErrors(Schema):
    """Orientation errors of a series with a calibration."""

    frames: tuple[int, ...]
    """Numbers of the frames that took part."""
    against_mean: OrientationDeviation
    """Against the mean orientation."""
    against_best: OrientationDeviation
    """Against that of the frame with the largest R²."""


class AllanReport(Schema):
    """Overlapping Allan deviation of f_nat with its confidence interval of 68.3 % (NIST SP 1065); lists are (n,)."""

    tau_s: tuple[float, ...]
    """Averaging times, multiples of the cadence, s."""
    deviation_hz: tuple[float, ...]
    """Allan deviation, Hz."""
    low_hz: tuple[float, ...]
    """Lower end of its confidence interval, Hz."""
    high_hz: tuple[float, ...]
    """Upper end of it, Hz."""
    noise: tuple[FrequencyNoise, ...]
    """Dominant noise of the frequency at each averaging time."""
    slope: float | None
    """Of log deviation against log averaging time: -1/2 white, 0 flicker, +1/2 random walk, +1 drift."""
    slope_std: float | None
    """Its standard deviation."""
    mean_hz: float
    """Mean of f_nat, Hz."""
    cadence_s: float
    """Time from frame to frame, s."""


class SeriesQuantities(Schema):
    """What the frames of a series tell together; null where they cannot, and `notes` say why."""

    orientation_error: OrientationErrors | None
    """Orientation errors against mean and best."""
    allan_deviation: AllanReport | None
    """Allan deviation of f_nat."""
    notes: tuple[str, ...]
    """Why something is missing."""


class UnfittedFrameQuantities(Schema):
    """A frame without a fit: nothing follows from it."""

    frame: int
    """Number of the frame, from 0."""


class FittedFrameQuantities(FrameQuantities, UnfittedFrameQuantities):
    """Quality factors of a good frame, with its number."""


class _Frames(Schema):
    frames: tuple[FittedFrameQuantities | UnfittedFrameQuantities, ...]
    """Frame by frame."""


class DerivedReport(SeriesQuantities, _Frames):
    """Derived quantities of a fit."""

    model_config = ConfigDict(json_schema_extra=example("derived_report"))


class EnvelopesReport(Schema):
    """Envelopes of a fitted frame over its window; lists are (points,)."""

    model_config = ConfigDict(json_schema_extra=example("envelopes_report"))

    frame: int
    """Number of the frame, from 0."""
    t_s: tuple[float, ...]
    """Time after the first RX sample, s."""
    amplitude_rad: tuple[float, ...]
    """Amplitude A(t) of the swing, rad."""
    v_am2_per_s: tuple[float, ...]
    """Envelope of dm/dt along the local axis v, A m^2/s."""
    u_am2_per_s: tuple[float, ...]
    """Envelope of dm/dt along the local axis u, A m^2/s."""
    frequency_minus_f_nat_hz: tuple[float, ...]
    """f(t) - f_nat, Hz: large swings are slower."""
