"""The plane test: a rotor of one angle moves its moment in the plane across its axis, and dm/dt has no part along it.

Crosstalk and a tilted frame bring parts of the other two there; a component proportional to the data across the axis is
taken out, as far as one constant factor for each can.

All shots must leave it alike, for something that disturbs one of them does so as well.  What swings less may leave it
much less, so that its noise may hide it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import grey_opening

from platform_daemon.diagnosis.shots.shot import DiagnosisShot, PreparedShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters

_LIMITS = THRESHOLDS.rigid_body


@dataclass(frozen=True, kw_only=True)
class ShotInPlane:
    """One shot's part along the main axis.

    ratio: its power over that of noise alone (1: none); sd: standard deviation of that; noise: rms of the noise there;
    signal: rms of the motion along all axes, in the same unit; swing_rad: amplitude.
    """

    ratio: float
    sd: float
    noise: float
    signal: float
    swing_rad: float

    @property
    def share(self) -> float:
        """The rms of the motion along the axis over that of the whole signal."""
        return self._share_of(self.ratio - 1.0)

    def leaves(self, sigma: float) -> bool:
        """By so many standard deviations, and far enough to be searched for its cause."""
        return self.ratio > 1.0 + sigma * self.sd and self.share > _LIMITS.plane_share

    def may_leave_like(self, other: ShotInPlane) -> bool:
        """Its noise may hide the least that another shot lets expect: the same share, or where it swings less a share
        that falls steeply with the swing."""
        most = self._share_of(self.ratio - 1.0 + _LIMITS.plane_hint_sigma * self.sd)
        return most >= min(1.0, self.swing_rad / other.swing_rad) ** _LIMITS.plane_steepest * other.share

    def _share_of(self, excess: float) -> float:
        return math.sqrt(max(excess, 0.0)) * self.noise / self.signal


@dataclass(frozen=True, kw_only=True)
class PlaneTest:
    """Of each shot."""

    shots: tuple[ShotInPlane, ...]

    @property
    def leaves(self) -> bool:
        """The motion leaves its plane: in every shot, or in one while the others may hide it."""
        return self._beyond(_LIMITS.plane_sigma)

    @property
    def may_leave(self) -> bool:
        """It seems to; noise does so once in a hundred shots, so that one angle must leave more than noise as well."""
        return self._beyond(_LIMITS.plane_hint_sigma)

    @property
    def share(self) -> tuple[float, ...]:
        """Of each shot that leaves it as far as is worth a search: the rms along the main axis over the signal's."""
        return tuple(s.share for s in self.shots if s.leaves(_LIMITS.plane_hint_sigma))

    def _beyond(self, sigma: float) -> bool:
        if self.shots and all(s.leaves(sigma) for s in self.shots):
            return True
        far = max((s for s in self.shots if s.leaves(_LIMITS.plane_sigma)), key=lambda s: s.share, default=None)
        return far is not None and all(s.leaves(sigma) or s.may_leave_like(far) for s in self.shots)


def plane_test(shots: Sequence[PreparedShot]) -> PlaneTest | None:
    """Of shots with fits of the declared model; None for what is not dm/dt in world axes."""
    found = []
    for one in shots:
        observed = one.state.observation
        if one.shot.record.quantity != "dmdt" or not isinstance(observed, DipoleObservation):
            return None
        found.append(_of_shot(one.shot, observed.rotation, one.state.dynamics))
    return PlaneTest(shots=tuple(found))


def _of_shot(shot: DiagnosisShot, rotation: Array, dynamics: MotionParameters) -> ShotInPlane:
    """From means over so many samples that three harmonics are left."""
    f_nat_hz = dynamics.w / (2.0 * np.pi)
    block = max(1, int(shot.rate_hz / (_LIMITS.plane_rate * f_nat_hz)))
    samples = shot.record.valid
    n = samples.shape[1] // block
    means = samples[:, : n * block].reshape(3, n, block).mean(axis=2)
    along, across = rotation[:, 2] @ means, rotation[:, :2].T @ means
    turns = 2.0 * np.pi * np.outer(shot.noise.tones_hz, np.arange(n)) * (block / shot.rate_hz)
    basis = np.vstack([across, np.ones(n), np.cos(turns), np.sin(turns)])
    left = along - np.linalg.lstsq(basis.T, along, rcond=None)[0] @ basis
    frequency_hz = np.fft.rfftfreq(n, block / shot.rate_hz)
    inside = (frequency_hz > _LIMITS.plane_from * f_nat_hz) & (frequency_hz < 0.5 * _LIMITS.plane_rate * f_nat_hz)
    density = np.array([np.interp(frequency_hz, shot.noise.frequency_hz, one) for one in shot.noise.psd])
    power = 0.5 * shot.rate_hz / block * np.asarray(rotation[:, 2] ** 2 @ density)
    level, level_sd = float(power[inside].mean()), 0.0
    if shot.noise.of_swings:
        peak = max(1, round(_LIMITS.plane_peak * f_nat_hz / float(frequency_hz[1])))
        spectrum = np.abs(np.fft.rfft(left)) ** 2 / n
        level, level_sd = _quiet_level(spectrum[inside], power[inside], grey_opening(power, size=(peak,))[inside])
    dof = n - len(basis)
    return ShotInPlane(
        ratio=float(left @ left) / (dof * level),
        sd=math.hypot(math.sqrt(2.0 / dof), level_sd),
        noise=math.sqrt(level),
        signal=math.sqrt(float(np.sum(means.var(axis=1)))),
        swing_rad=abs(dynamics.amplitude),
    )


def _quiet_level(spectrum: Array, measured: Array, colour: Array) -> tuple[float, float]:
    """The noise's power along the axis, and its standard deviation over it: as measured and 0 where that is not surely
    too large.

    Without blank shots the noise is measured between the harmonics.  There stand the lines of side modes, and the
    harmonics of a frequency that changes along the ring-down: what leaves the plane is then taken for noise, seven
    times as much of it at a side mode.  The level is therefore the mean of what stands along the axis, in units of the
    noise's colour, over all stretches of frequencies but those that stand out, with their neighbours.

    spectrum, measured: (k,) of what stands along the axis and of the noise; colour: (k,) of the noise without its
    narrow peaks.  A grey opening cuts them off, and leaves slopes as they are.
    """
    width = _LIMITS.plane_stretch
    if spectrum.size < width or not colour.min() > 0.0:
        return float(measured.mean()), 0.0
    over = spectrum / colour
    smooth = np.convolve(over, np.full(width, 1.0 / width), mode="same")
    level, quiet = float(np.median(smooth)), np.ones(over.size, dtype=bool)
    for _ in range(_LIMITS.plane_turns):
        out = smooth > level * (1.0 + _LIMITS.plane_out_sigma / math.sqrt(width))
        quiet = np.convolve(out, np.ones(width), mode="same") < 0.5  # less than one that stands out
        if not quiet.any():
            return float(measured.mean()), 0.0
        level = float(np.mean(over[quiet]))
    found, sd = level * float(colour.mean()), 1.0 / math.sqrt(np.count_nonzero(quiet))
    surely_less = found < float(measured.mean()) * (1.0 - _LIMITS.plane_hint_sigma * sd - _LIMITS.plane_level_share)
    return (found, sd) if surely_less else (float(measured.mean()), 0.0)
