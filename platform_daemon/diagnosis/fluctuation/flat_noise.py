"""Noise beside a line that fluctuates: flat, as it is far above the harmonics.

Without blank shots the noise is measured between the harmonics.  A frequency that fluctuates widens its lines by tens
of hertz, and what stands there is its motion: by it the noise at the fundamental seems twice as large as it is, and
that at 1 kHz half as large.  Far above the harmonics nothing of it is left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.shots.shot import PreparedShot, whitening_for
from platform_daemon.estimation.noise.model import NoiseModel


def with_flat_noise(prepared: Sequence[PreparedShot]) -> list[PreparedShot] | None:
    """The shots with flat noise of the level of the upper half of their band; None where the noise is flat already,
    was measured in blank shots, or is known from elsewhere."""
    found = [_flat(shot) for shot in prepared]
    return None if all(a is b for a, b in zip(found, prepared, strict=True)) else found


def _flat(prepared: PreparedShot) -> PreparedShot:
    shot, noise = prepared.shot, prepared.shot.noise
    if noise.blank or noise.degrees is None or all(shape is None for shape in prepared.white.filters):
        return prepared
    grid = noise.frequency_hz
    level = np.median(noise.psd[:, grid > 0.5 * grid[-1]], axis=1)
    flat = replace(shot, noise=NoiseModel.white(np.sqrt(0.5 * shot.rate_hz * level), shot.rate_hz))
    return replace(prepared, shot=flat, white=whitening_for(flat, prepared.grids, _fundamental_hz(prepared)))


def _fundamental_hz(prepared: PreparedShot) -> float:
    """Of a shot's fit."""
    return prepared.state.dynamics.w / (2.0 * math.pi)
