"""The plane test: a rotor of one angle moves its moment in the plane across its axis, and dm/dt has no part along it.

Crosstalk and a tilted frame bring parts of the other two there; a component proportional to the data across the axis is
taken out, as far as one constant factor for each can.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.shots.shot import DiagnosisShot, PreparedShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.rigid_body


@dataclass(frozen=True, kw_only=True)
class PlaneTest:
    """Of each shot: power along the main axis over that of noise alone (1: none), its standard deviation, and the rms
    of the motion there over that of the whole signal."""

    ratio: tuple[float, ...]
    sd: tuple[float, ...]
    share: tuple[float, ...]

    @property
    def leaves(self) -> bool:
        """The motion leaves its plane, in every shot."""
        return self._beyond(_LIMITS.plane_sigma)

    @property
    def may_leave(self) -> bool:
        """It seems to; noise does so once in a hundred shots, so that one angle must leave more than noise as well."""
        return self._beyond(_LIMITS.plane_hint_sigma)

    def _beyond(self, sigma: float) -> bool:
        far = (r > 1.0 + sigma * s for r, s in zip(self.ratio, self.sd, strict=True))
        return all(far) and min(self.share) > _LIMITS.plane_share


def plane_test(shots: Sequence[PreparedShot]) -> PlaneTest | None:
    """Of shots with fits of the declared model; None for what is not dm/dt in world axes."""
    rows = []
    for one in shots:
        observed = one.state.observation
        if one.shot.record.quantity != "dmdt" or not isinstance(observed, DipoleObservation):
            return None
        rows.append(_of_shot(one.shot, observed.rotation, one.state.dynamics.w / (2.0 * np.pi)))
    ratio, sd, share = zip(*rows, strict=True)
    return PlaneTest(ratio=ratio, sd=sd, share=share)


def _of_shot(shot: DiagnosisShot, rotation: Array, f_nat_hz: float) -> tuple[float, float, float]:
    """Ratio, its standard deviation, share, from means over so many samples that three harmonics are left."""
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
    power, dof = float(left @ left), n - len(basis)
    share = float(np.sqrt(max(power / dof - level, 0.0) / np.mean(np.sum(means**2, axis=0))))
    return power / (dof * level), float(np.sqrt(2.0 / dof)), share
