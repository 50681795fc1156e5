"""How far the harmonic estimator lies from the fit of the same record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.harmonic_estimator.estimator import HarmonicEstimate
from platform_daemon.estimation.physics.orbit import frequency_ratio
from platform_daemon.estimation.result import FitResult
from platform_daemon.features.fit.series.orientation import error_angle


@dataclass(frozen=True)
class BiasAgainstFit:
    """Estimate minus fit: sweep_hz (change of f over the stretch, from the fit), then the differences."""

    sweep_hz: float
    f_nat_hz: float
    m_r_relative: float
    amplitude_rad: float
    orientation_rad: float


def bias_against_fit(estimate: HarmonicEstimate, fit: FitResult) -> BiasAgainstFit:
    """How far the estimate lies from a fit of the same record, at the estimate's own time.  Raises: ValueError."""
    ring_down = fit.ring_down()
    if ring_down.m_r_am2 is None:
        raise ValueError("a fit in volts has neither m_r nor orientation to compare with")
    half = 0.5 * estimate.stretch_s
    times = np.array([max(0.0, estimate.time_s - half), estimate.time_s, estimate.time_s + half])
    amplitude = 2.0 * np.arcsin(0.5 * ring_down.peak_rate(times))
    first, last = (frequency_ratio(float(a)) * ring_down.f_nat_hz for a in amplitude[[0, 2]])
    reference = np.array([fit.parameters[f"rodrigues_{axis}"].value for axis in "xyz"])
    return BiasAgainstFit(
        sweep_hz=last - first,
        f_nat_hz=estimate.f_nat_hz - ring_down.f_nat_hz,
        m_r_relative=estimate.m_r_am2 / ring_down.m_r_am2 - 1.0,
        amplitude_rad=estimate.amplitude_rad - float(amplitude[1]),
        orientation_rad=float(error_angle(estimate.rodrigues, reference)),
    )
