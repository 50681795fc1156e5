"""From a converged fit to one that is joint with the steady tones and the drift that its residual shows, if any."""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.nuisance import Nuisance, NuisanceFit, fit_with_nuisance
from platform_daemon.estimation.least_squares.problem import FitProblem, Minimum
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.noise.tones_and_drift import drift_degree, find_tones, may_hold_tones
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.screening.spectral_lines import Zones
from platform_daemon.estimation.screening.windows import SampleRange
from platform_daemon.estimation.thresholds import THRESHOLDS

from .block_residual import residual_of
from .residual import Residual

LIMITS = THRESHOLDS.goodness_of_fit


def fit_with_interference(
    problem: FitProblem, best: Minimum, residual: Residual, chosen: SampleRange, noise: NoiseModel, frequency_hz: float
) -> NuisanceFit | None:
    """The joint fit, from one that left this residual; None if nothing in that is steady and no part of the signal.

    Raises:
        NoConvergenceError, LostTrajectoryError, numpy.linalg.LinAlgError: the joint fit leads nowhere.
    """
    if residual.is_rounding:
        return None
    now, fitted, joint = problem, best, None
    tones, degree = _known_tones(noise, best.state, chosen, problem.record.dt_s), 0
    for _ in range(LIMITS.tone_rounds):
        if joint is not None:
            residual = residual_of(
                now.record, now.workspace, fitted.tabulated, chosen=chosen, noise=noise, noise_sd=now.noise_sd
            )
        found, steeper = _seen(residual, fitted.state, chosen, now.record.dt_s, joint is None)
        new = [f for f in found if np.all(np.abs(tones - f) > 1.0 / _seconds(chosen, now.record.dt_s))]
        if joint is not None and not new and steeper <= degree:
            break
        tones = np.concatenate([tones, new])
        # A slow tone looks like drift: what is drift shows once the tones are removed.
        degree = degree if new and joint is None else max(degree, steeper)
        if tones.size == 0 and degree == 0:
            return None
        nuisance = Nuisance(tones_hz=tones, degree=degree, first=chosen.first, last=chosen.last)
        freed = noise.without_tones(tones)
        # What was raised above rounding stays there.
        sd = np.where(problem.noise_sd > noise.sd, problem.noise_sd, freed.sd)
        joint = fit_with_nuisance(problem, best, nuisance, freed, sd, frequency_hz)
        now, fitted = joint.problem, joint.fitted
    return joint


def _seconds(chosen: SampleRange, dt_s: float) -> float:
    return (chosen.last - chosen.first) * dt_s


def _seen(residual: Residual, state: FitState, chosen: SampleRange, dt_s: float, first_look: bool) -> tuple[Array, int]:
    """Frequencies of steady tones in a residual, (tones,), and the degree of its drift."""
    degree = drift_degree(residual.scaled)
    # A cheap look first: few records are disturbed.
    if first_look and not may_hold_tones(residual.transformed, residual.with_lines):
        return np.empty(0), degree
    zones = zones_of(state, LIMITS.tone_apart_cycles / _seconds(chosen, dt_s))
    return find_tones(residual.scaled, residual.rate_hz, zones), degree


def _known_tones(noise: NoiseModel, state: FitState, chosen: SampleRange, dt_s: float) -> Array:
    """Tones of the noise model that can be separated from the signal in this window."""
    tones, seconds = np.array(noise.tones_hz), _seconds(chosen, dt_s)
    if tones.size == 0:
        return tones
    apart = ~zones_of(state, LIMITS.known_tone_apart_cycles / seconds).holds(tones)
    return np.asarray(tones[apart & (tones * seconds > LIMITS.known_tone_apart_cycles)])


def zones_of(state: FitState, margin_hz: float) -> Zones:
    """Where the harmonics of a fitted motion are as it decays."""
    d = state.dynamics
    return Zones.of_sweep(d.w, d.amplitude, relative=LIMITS.tone_sweep_share, margin_hz=margin_hz)
