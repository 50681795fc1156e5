"""From a converged fit to one that is joint with the steady tones and the drift that its residual shows, if any."""

from __future__ import annotations

import numpy as np

from ..least_squares.gauss_newton import FitState
from ..least_squares.nuisance import Nuisance, NuisanceFit, fit_with_nuisance
from ..least_squares.problem import FitProblem, Minimum
from ..noise.model import NoiseModel
from ..noise.tones_and_drift import drift_degree, find_tones, may_hold_tones
from ..numerics.arrays import Array
from ..screening.spectral_lines import Zones
from ..screening.windows import SampleRange
from .block_residual import residual_of
from .residual import Residual
from .thresholds import LIMITS

_ROUNDS = 2  # a strong disturbance hides a weak one
_SWEEP_MARGIN = 0.01


def without_interference(
    problem: FitProblem, best: Minimum, residual: Residual, chosen: SampleRange, noise: NoiseModel, frequency_hz: float
) -> NuisanceFit | None:
    """The joint fit, from one that left this residual; None if nothing in that is steady and no part of the signal.

    Raises:
        NoConvergenceError, LostTrajectoryError, numpy.linalg.LinAlgError: the joint fit leads nowhere.
    """
    if residual.is_rounding:
        return None
    now, fitted, beside = problem, best, None
    tones, degree = _known_tones(noise, best.state, chosen, problem.record.dt_s), 0
    for _ in range(_ROUNDS):
        if beside is not None:
            residual = residual_of(now.record, now.workspace, fitted.tabulated, chosen, noise, now.noise_sd)
        found, steeper = _seen(residual, fitted.state, chosen, now.record.dt_s, beside is None)
        new = [f for f in found if np.all(np.abs(tones - f) > 1.0 / _seconds(chosen, now.record.dt_s))]
        if beside is not None and not new and steeper <= degree:
            break
        tones = np.concatenate([tones, new])
        # A slow tone looks like drift: what is drift shows once the tones are gone.
        degree = degree if new and beside is None else max(degree, steeper)
        if tones.size == 0 and degree == 0:
            return None
        nuisance = Nuisance(tones, degree, chosen.first, chosen.last)
        freed = noise.without_tones(tones)
        # What was raised above rounding stays there.
        sd = np.where(problem.noise_sd > noise.sd, problem.noise_sd, freed.sd)
        beside = fit_with_nuisance(problem, best, nuisance, freed, sd, frequency_hz)
        now, fitted = beside.problem, beside.fitted
    return beside


def _seconds(chosen: SampleRange, dt_s: float) -> float:
    return (chosen.last - chosen.first) * dt_s


def _seen(residual: Residual, state: FitState, chosen: SampleRange, dt_s: float, first_look: bool) -> tuple[Array, int]:
    """Frequencies of steady tones in a residual, (tones,), and the degree of its drift."""
    degree = drift_degree(residual.scaled)
    # A cheap look first: hardly any record is disturbed.
    if first_look and not may_hold_tones(residual.transformed, residual.with_lines):
        return np.empty(0), degree
    zones = zones_of(state, LIMITS.tone_apart_cycles / _seconds(chosen, dt_s))
    return find_tones(residual.scaled, residual.rate_hz, zones), degree


def _known_tones(noise: NoiseModel, state: FitState, chosen: SampleRange, dt_s: float) -> Array:
    """Tones of the noise model that can be told from the signal in this window."""
    tones, seconds = np.array(noise.tones_hz), _seconds(chosen, dt_s)
    if tones.size == 0:
        return tones
    apart = ~zones_of(state, LIMITS.known_tone_apart_cycles / seconds).holds(tones)
    return np.asarray(tones[apart & (tones * seconds > LIMITS.known_tone_apart_cycles)])


def zones_of(state: FitState, margin_hz: float) -> Zones:
    """Where the harmonics of a fitted motion are as it decays."""
    d = state.dynamics
    return Zones.of_sweep(d.w, d.amplitude, relative=_SWEEP_MARGIN, margin_hz=margin_hz)
