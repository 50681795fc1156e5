"""What white noise that is added to recorded shots does to the estimates of N50 (fig:noise_plot)."""

from __future__ import annotations

from platform_daemon.core.schemas.base import Interval, Schema, Vector


class NoisePoint(Schema):
    """All fits of one specimen at one level of noise."""

    level_am2_per_s: float
    """Mean over the channels of the standard deviation of one sample, A m^2/s."""
    fits: int
    """Fits made."""
    failed: int
    """Fits without a result; each counts as further away than any other."""
    f_nat_mad_hz: float | None
    """Median absolute deviation of f_nat from its median, Hz; null: more than half of the fits failed."""
    f_nat_mad_interval_hz: Interval | None
    """Its 95 % interval, by bootstrap over the shots, Hz; null: an end of it is not known."""
    f_nat_mad_predicted_hz: float
    """What the Cramer-Rao bound and the scatter of the shots predict of it, Hz."""
    orientation_median_rad: float | None
    """Median angle to the orientation of reference, rad; null: more than half of the fits failed."""
    orientation_interval_rad: Interval | None
    """Its 95 % interval, by bootstrap over the shots, rad; null: an end of it is not known."""
    orientation_predicted_rad: float
    """What the Cramer-Rao bound and the scatter of the shots predict of it, rad."""


class NoiseCurve(Schema):
    """One specimen over all levels."""

    specimen: str
    """Its file."""
    variant: str
    """Model that was fitted."""
    own_level_am2_per_s: float
    """Level of noise in the recording itself, A m^2/s."""
    points: tuple[NoisePoint, ...]
    """Level by level."""


class BreakEven(Schema):
    """Where the second specimen becomes more precise than the first."""

    quantity: str
    """f_nat_hz or orientation."""
    level_am2_per_s: float | None
    """Level of noise from which on it is, A m^2/s; null: at no level of the sweep, or at all of them, see `reason`."""
    interval_am2_per_s: Interval | None
    """95 % interval by bootstrap over the shots; null: some of the draws have no such level."""
    reason: str | None
    """Why there is none; null: there is one."""


class NoisePlan(Schema):
    """What the parts of a noise sweep belong to; parts of another plan are not put together with them."""

    software_version: str
    """Version of the software."""
    specimens: tuple[str, ...]
    """Digest of each specimen's recording, and of how it is fitted."""
    levels_am2_per_s: tuple[float, ...]
    """Levels of noise, A m^2/s."""
    draws: int
    """Draws of noise for each shot and level."""
    seed: int
    """Of the noise."""
    parts: int
    """Parts that it is cut into."""


class NoiseDraw(Schema):
    """A fit of a shot with noise added."""

    frame: int
    """Frame, from 0."""
    level: int
    """Number of the level, from 0."""
    f_nat_hz: float | None
    """f_nat, Hz; null: the fit failed."""
    rodrigues_rad: Vector | None
    """Orientation, rad; null: the fit failed."""


class NoisePart(Schema):
    """The fits of some shots of one specimen."""

    specimen: int
    """Its number, from 0."""
    fits: tuple[NoiseDraw, ...]
    """All of them."""


class NoiseSweepReport(Schema):
    """A noise sweep over the shots of two specimens."""

    draws: int
    """Draws of noise for each shot and level."""
    seed: int
    """Of the noise and of the bootstrap."""
    curves: tuple[NoiseCurve, ...]
    """Of each specimen."""
    break_even: tuple[BreakEven, ...]
    """Of f_nat and of the orientation."""
