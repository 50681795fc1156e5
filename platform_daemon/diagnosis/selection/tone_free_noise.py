"""Noise without the steady tones that stand in the residual: these are to be explained, not to be weighted with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.estimation import Array

from ..regression.joint_fit import JointFit, fit_jointly
from ..shots.shot import PreparedShot, whitening_for
from .component_search import shot_residuals, tones


def with_tone_free_noise(base: JointFit, pool: Executor) -> JointFit:
    """The joint fit again, with noise spectra bridged at the tones; as it is where there are none.

    The quiet parts that tell the noise hold the tones too. Counted as noise they would hide themselves, and chi^2 per
    degree of freedom would fall below 1 once they are explained.
    """
    found = np.array([f for c in tones(base, shot_residuals(base, pool)) for f in c.tones_hz])
    if not found.size:
        return base
    return fit_jointly(_quieter(base.started, found), base.hypothesis, pool, base.states)


def _quieter(started: Sequence[PreparedShot], tones_hz: Array) -> list[PreparedShot]:
    out = []
    for s in started:
        shot = replace(s.shot, noise=s.shot.noise.without_tones(tones_hz))
        out.append(replace(s, shot=shot, white=whitening_for(shot, s.grids, s.state.dynamics.w / (2.0 * math.pi))))
    return out
