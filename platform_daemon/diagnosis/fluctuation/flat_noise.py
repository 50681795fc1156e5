"""Noise beside a line that fluctuates: flat, as it is far above the harmonics.

Without blank shots the noise is measured between the harmonics.  A frequency that fluctuates widens their lines by tens
of hertz, and is then taken for noise: that at the fundamental seemed twice as large as it was, and that at 1 kHz half
as large.  Far above the harmonics nothing of it is left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from platform_daemon.diagnosis.shots.shot import PreparedShot, whitening_for


def with_flat_noise(prepared: Sequence[PreparedShot]) -> list[PreparedShot] | None:
    """The shots with flat noise of the level far above their harmonics; None where the noise of all of them is flat
    already, was measured in blank shots, or is known from elsewhere."""
    found = [_flat(shot) for shot in prepared]
    return None if all(a is b for a, b in zip(found, prepared, strict=True)) else found


def _flat(prepared: PreparedShot) -> PreparedShot:
    shot, noise = prepared.shot, prepared.shot.noise
    if noise.blank or noise.degrees is None or all(shape is None for shape in prepared.white.filters):
        return prepared
    flat = replace(shot, noise=noise.flattened())
    return replace(
        prepared, shot=flat, white=whitening_for(flat, prepared.grids, prepared.state.dynamics.w / (2.0 * math.pi))
    )
