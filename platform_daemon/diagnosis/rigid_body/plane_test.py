"""The plane test: a rotor of one angle moves its moment in the plane across its axis, and dm/dt has no part along it.

Crosstalk and a tilted frame bring parts of the other two there; a component proportional to the data across the axis is
taken out, as far as one constant factor for each can.

All shots must leave it alike, for something that disturbs one of them does so as well.  What swings less leaves it
less: with the square of the swing or faster.  In a shot with half the amplitude a quarter of the share, or less, is to
be expected, which may drown in its noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.shots.shot import DiagnosisShot, PreparedShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.rigid_body


@dataclass(frozen=True, kw_only=True)
class ShotInPlane:
    """One shot's part along the main axis.

    ratio: its power over that of noise alone (1: none); sd: standard deviation of that; signal: rms of the motion along
    all axes over the noise's along the main one.
    """

    ratio: float
    sd: float
    signal: float

    @property
    def share(self) -> float:
        """The rms of the motion along the axis over that of the whole signal."""
        return self._share_of(self.ratio - 1.0)

    def leaves(self, sigma: float) -> bool:
        """By so many standard deviations, and far enough to be searched for its cause."""
        return self.ratio > 1.0 + sigma * self.sd and self.share > _LIMITS.plane_share

    def may_leave_like(self, other: ShotInPlane) -> bool:
        """It swings no more than another one, and its noise may hide what that lets expect of it."""
        swing = self.signal / other.signal
        most = self._share_of(self.ratio - 1.0 + _LIMITS.plane_hint_sigma * self.sd)
        return most >= min(1.0, swing) ** 2 * other.share

    def _share_of(self, excess: float) -> float:
        return math.sqrt(max(excess, 0.0)) / self.signal


@dataclass(frozen=True, kw_only=True)
class PlaneTest:
    """Of each shot."""

    shots: tuple[ShotInPlane, ...]

    @property
    def leaves(self) -> bool:
        """The motion leaves its plane, in every shot in which that could be seen."""
        return self._beyond(_LIMITS.plane_sigma)

    @property
    def may_leave(self) -> bool:
        """It seems to; noise does so once in a hundred shots, so that one angle must leave more than noise as well."""
        return self._beyond(_LIMITS.plane_hint_sigma)

    @property
    def share(self) -> tuple[float, ...]:
        """Of each shot in which it is seen: the rms of the motion along the main axis over that of the signal."""
        return tuple(s.share for s in self.shots if s.leaves(_LIMITS.plane_hint_sigma))

    def _beyond(self, sigma: float) -> bool:
        far = max((s for s in self.shots if s.leaves(sigma)), key=lambda s: s.share, default=None)
        return far is not None and all(s.leaves(sigma) or s.may_leave_like(far) for s in self.shots)


def plane_test(shots: Sequence[PreparedShot]) -> PlaneTest | None:
    """Of shots with fits of the declared model; None for what is not dm/dt in world axes."""
    found = []
    for one in shots:
        observed = one.state.observation
        if one.shot.record.quantity != "dmdt" or not isinstance(observed, DipoleObservation):
            return None
        found.append(_of_shot(one.shot, observed.rotation, one.state.dynamics.w / (2.0 * np.pi)))
    return PlaneTest(shots=tuple(found))


def _of_shot(shot: DiagnosisShot, rotation: Array, f_nat_hz: float) -> ShotInPlane:
    """From means over so many samples that three harmonics are left."""
    block = max(1, int(shot.rate_hz / (_LIMITS.plane_rate * f_nat_hz)))
    samples = shot.record.valid
    n = samples.shape[1] // block
    means = samples[:, : n * block].reshape(3, n, block).mean(axis=2)
    along, across = rotation[:, 2] @ means, rotation[:, :2].T @ means
    turns = 2.0 * np.pi * np.outer(shot.noise.tones_hz, np.arange(n)) * (block / shot.rate_hz)
    basis = np.vstack([across, np.ones(n), np.cos(turns), np.sin(turns)])
    left = along - np.linalg.lstsq(basis.T, along, rcond=None)[0] @ basis
    band = np.linspace(_LIMITS.plane_from, 0.5 * _LIMITS.plane_rate, _LIMITS.plane_points) * f_nat_hz
    density = np.array([np.interp(band, shot.noise.frequency_hz, one).mean() for one in shot.noise.psd])
    level = float(rotation[:, 2] ** 2 @ density) * 0.5 * shot.rate_hz / block
    dof = n - len(basis)
    return ShotInPlane(
        ratio=float(left @ left) / (dof * level),
        sd=math.sqrt(2.0 / dof),
        signal=math.sqrt(float(np.mean(np.sum(means**2, axis=0))) / level),
    )
