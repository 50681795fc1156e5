"""Variations from shot to shot: temperature, friction, wear, orientation, frequency, damping."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivers.specimen import RotorModel
from sim_backend.hidden_effects.listing import HiddenEffects, first
from sim_backend.hidden_effects.torques import FrequencyFluctuation, FrictionFluctuation
from sim_backend.options import EffectsOptions, HousingOptions, TemperatureEffect
from sim_backend.rotor.rotor import FLUCTUATION_WAVES, Rotor, rotation_matrix

GRID_PER_CORRELATION = 50
_FASTEST_PART = 0.99  # of the spectrum of what fluctuates: no wave is faster than 64 / tau


class Temperature:
    """Temperature at the resonator in world time: an Ornstein-Uhlenbeck process on a fixed grid, linear in between.

    The temperature depends on seed and time only, not on the number or order of calls.
    """

    def __init__(self, effect: TemperatureEffect, rng: np.random.Generator, time_constant_s: float = 0.0) -> None:
        self._effect = effect
        self._rng = rng
        self._step_s = effect.correlation_time_s / GRID_PER_CORRELATION
        self._deviations = [float(rng.standard_normal())]
        self._time_constant_s = time_constant_s
        self._inside = self._deviations[:]

    def deviation_k(self, world_s: float) -> float:
        """Deviation from the mean at a world time, K; zero if the effect is off."""
        if not self._effect.enabled:
            return 0.0
        place = max(world_s, 0.0) / self._step_s
        k = int(place)
        self._extend(k + 2)
        low, high = self._deviations[k], self._deviations[k + 1]
        return self._effect.sd_k * (low + (place - k) * (high - low))

    def inside_k(self, world_s: float) -> float:
        """The same inside of a housing with a thermal time constant: of first order, in equilibrium at the start."""
        if not self._effect.enabled or self._time_constant_s == 0.0:
            return self.deviation_k(world_s)
        k = int(max(world_s, 0.0) / self._step_s)
        self._extend(k + 2)
        while len(self._inside) <= k + 1:
            at = len(self._inside)
            low, high = self._deviations[at - 1 : at + 1]
            behind = (high - low) / self._step_s * self._time_constant_s
            keep = float(np.exp(-self._step_s / self._time_constant_s))
            self._inside.append(high - behind + (self._inside[-1] - low + behind) * keep)
        part = max(world_s, 0.0) / self._step_s - k
        return self._effect.sd_k * (self._inside[k] + part * (self._inside[k + 1] - self._inside[k]))

    def celsius(self, world_s: float) -> float:
        """Temperature at a world time, deg C."""
        return float(self._effect.mean_c + self.deviation_k(world_s))

    def _extend(self, length: int) -> None:
        keep = float(np.exp(-1 / GRID_PER_CORRELATION))
        spread = np.sqrt(1 - keep**2)
        while len(self._deviations) < length:
            self._deviations.append(keep * self._deviations[-1] + spread * float(self._rng.standard_normal()))


def pressure_mbar(housing: HousingOptions, world_s: float) -> float:
    """Pressure on the housing at a world time, mbar."""
    return float(housing.mean_mbar + housing.swing_mbar * np.sin(2 * np.pi * world_s / housing.period_s))


def under_pressure(rotor: Rotor, housing: HousingOptions, world_s: float) -> Rotor:
    """The rotor with f_nat at the pressure of a world time."""
    d = pressure_mbar(housing, world_s) - housing.mean_mbar
    shift_hz = housing.f_nat_hz_per_mbar * d + housing.f_nat_hz_per_mbar2 * d**2
    return replace(rotor, f_nat_hz=rotor.f_nat_hz + shift_hz) if shift_hz else rotor


def friction_factor(effects: EffectsOptions, rng: np.random.Generator, earlier_shots: int) -> float:
    """Factor on T_f in one shot: scatter (lognormal, mean 1) times wear."""
    factor = 1.0
    if effects.friction_scatter.enabled:
        sigma = np.sqrt(np.log1p(effects.friction_scatter.relative_sd**2))
        factor *= float(np.exp(rng.normal(-(sigma**2) / 2, sigma)))
    if effects.wear.enabled:
        factor *= 1 + effects.wear.relative_per_shot * earlier_shots
    return factor


def with_fluctuations(rotor: Rotor, effects: HiddenEffects, rng: np.random.Generator) -> Rotor:
    """The rotor in one shot with the waves of its friction and of f_nat; nothing is drawn for what does not fluctuate.

    The frequencies are one from each of equal parts of the spectrum of exp(-|t| / tau), a Lorentzian.
    """
    friction, frequency = first(effects, FrictionFluctuation), first(effects, FrequencyFluctuation)
    if friction is not None:
        rotor = replace(rotor, friction_waves=_waves(friction.tau_s, rng))
    if frequency is not None:
        rotor = replace(rotor, frequency_waves=_waves(frequency.tau_s, rng))
    return rotor


def _waves(tau_s: float, rng: np.random.Generator) -> NDArray[np.float64]:
    part = (np.arange(FLUCTUATION_WAVES) + rng.uniform(0.0, 1.0, FLUCTUATION_WAVES)) / FLUCTUATION_WAVES
    omega = np.tan(0.5 * np.pi * np.minimum(part, _FASTEST_PART)) / tau_s
    return np.column_stack([omega, rng.uniform(0.0, 2 * np.pi, FLUCTUATION_WAVES)])


def with_scatter(rotor: Rotor, scatter: RotorModel, rng: np.random.Generator) -> Rotor:
    """The rotor in one shot, turned, and with another f_nat and lambda, by the normal scatter that its file declares.

    The paper measured such a scatter of its resonators (tab:model_params_fit_result): the jewel's orientation differs
    by 0.08 to 0.13 deg from a reference shot on average, more than ten times as much as the thread's.  Nothing is drawn
    for what does not scatter.
    """
    turns_rad = np.broadcast_to(scatter.orientation_scatter_rad, 3)
    if np.any(turns_rad):
        rotor = replace(rotor, rotation=rotor.rotation @ rotation_matrix(rng.normal(0.0, turns_rad)))
    if scatter.f_nat_scatter_hz:
        rotor = replace(rotor, f_nat_hz=rotor.f_nat_hz + rng.normal(0.0, scatter.f_nat_scatter_hz))
    if scatter.lambda_scatter:
        factor = max(0.0, rng.normal(1.0, scatter.lambda_scatter))
        rotor = replace(rotor, lambda_per_s=rotor.lambda_per_s * factor)
    return rotor


def rotor_in_shot(rotor: Rotor, effects: EffectsOptions, deviation_k: float, friction: float) -> Rotor:
    """The rotor in one shot: f_nat and m_r at the temperature, T_f times the factor `friction`.

    The inertia does not depend on temperature.  T_f varies with the position of the contact in the jewel, for a rigid
    body too.  By eq:tf, T_f is proportional to mu and to the radius of the contact; the radius is varied, because a
    varying mu would let the sphere slip at a different field each time, so that side modes would begin anywhere between
    460 and 700 uT.
    """
    warm = effects.temperature
    return replace(
        rotor,
        f_nat_hz=rotor.f_nat_hz + warm.f_nat_hz_per_k * deviation_k,
        m_r_am2=rotor.m_r_am2 * (1 + warm.m_r_per_k * deviation_k),
        tf_over_i_rad_per_s2=rotor.tf_over_i_rad_per_s2 * friction,
        contact=friction,
    )
