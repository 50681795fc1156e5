"""Hidden torques without an internal state: their slots in the parameter array, and their kernels."""

from __future__ import annotations

from math import cos, exp, pi

import numpy as np
from numpy.typing import NDArray

from drivers.errors import ConfigError
from sim_backend.hidden_effects.internal_states import (
    BreathingGap,
    MemoryAmplitude,
    MemoryBristle,
    MemoryRelaxation,
    SecondMode,
)
from sim_backend.hidden_effects.listing import HiddenEffects, first, strength
from sim_backend.hidden_effects.torques import (
    AngleDependentDamping,
    BiasTorque,
    CoulombFriction,
    FrequencyDrift,
    FrequencyFluctuation,
    FrictionFluctuation,
    HertzFriction,
    QuadraticDrag,
    RestoringAnharmonicity,
    StribeckFriction,
    TorsionStiffness,
)

from .kernel import kernel
from .rotor import FLUCTUATION_WAVES, later_waves

# Slots that follow those of `torque`; there, 1 is omega_nat^2 and 2 the declared Hertz friction.
OMEGA_SQUARED, HERTZ = 1, 2
SMOOTH = 7  # not 0: one of the smooth torques acts
ANGLE_DAMPING, ANHARMONICITY, TORSION, BIAS = 8, 9, 10, 11
DRIFT, DRIFT_FROM, DRIFT_TAU = 12, 13, 14  # rad/s^2, s on the field's time axis, s (0: linear)
KINKS = 15  # not 0: one of the next four acts, or bristles, or friction fluctuates
COULOMB, STRIBECK, STRIBECK_SPEED, DRAG = 16, 17, 18, 19
RELAXATION, RELAXATION_RATE = 20, 21  # k w^2, 1/tau
BRISTLE, BRISTLE_REACH = 22, 23
AMPLITUDE, AMPLITUDE_RATE = 24, 25  # k w^2, 1/tau
GAP, GAP_OMEGA, GAP_DAMPING = 26, 27, 28  # s, W, 2 g
MODE, MODE_OMEGA, MODE_DAMPING, MODE_ORDER = 29, 30, 31, 32  # c w^2, W, 2 g
FLUCTUATION, WAVES = 33, 34  # s; then angular frequency, rad/s, and phase, rad, of each wave
WAVES_END = WAVES + 2 * FLUCTUATION_WAVES
UNSTEADY, UNSTEADY_WAVES = WAVES_END, WAVES_END + 1  # of omega_nat: rad/s; then as of friction
SLOTS = UNSTEADY_WAVES + 2 * FLUCTUATION_WAVES


def fill(
    q: NDArray[np.float64],
    effects: HiddenEffects,
    drift_from_s: float | None,
    waves: tuple[NDArray[np.float64] | None, NDArray[np.float64] | None] = (None, None),
    now_s: float = 0.0,
) -> None:
    """Enter all effects into a parameter array (SLOTS,) that contains the declared torques, in place.

    drift_from_s: start of the drift of f_nat on the time axis of the field, s; None: no drift.  waves: of the friction
    and of f_nat in this shot, see `Rotor`, None: it does not fluctuate; now_s: time zero of the field on their time
    axis, s.
    Raises ConfigError for Stribeck's law and a fluctuation without dry friction, and for an unstable second mode.
    """
    q[HERTZ] += strength(effects, HertzFriction)
    q[COULOMB] = strength(effects, CoulombFriction)
    q[DRAG] = strength(effects, QuadraticDrag)
    if stribeck := first(effects, StribeckFriction):
        q[STRIBECK] = stribeck.strength
        q[STRIBECK_SPEED] = stribeck.v_s_rad_per_s
        _check_friction(q, "for Stribeck's law to change", "stribeck_friction")
    if fluctuation := first(effects, FrictionFluctuation):
        _check_friction(q, "that could fluctuate", "friction_fluctuation")
        if waves[0] is not None:
            q[FLUCTUATION] = fluctuation.strength
            q[WAVES:WAVES_END] = later_waves(waves[0], now_s).ravel()
    q[ANGLE_DAMPING] = 2 * strength(effects, AngleDependentDamping)
    q[ANHARMONICITY] = strength(effects, RestoringAnharmonicity)
    q[TORSION] = strength(effects, TorsionStiffness)
    q[BIAS] = strength(effects, BiasTorque)
    if (drift := first(effects, FrequencyDrift)) and drift_from_s is not None:
        q[DRIFT] = 2 * pi * drift.strength
        q[DRIFT_FROM] = drift_from_s
        q[DRIFT_TAU] = drift.tau_s or 0.0
    if (unsteady := first(effects, FrequencyFluctuation)) and waves[1] is not None:
        q[UNSTEADY] = 2 * pi * unsteady.strength
        q[UNSTEADY_WAVES:] = later_waves(waves[1], now_s).ravel()
    q[SMOOTH] = float(np.any(q[[ANGLE_DAMPING, ANHARMONICITY, TORSION, BIAS, DRIFT, UNSTEADY]]))
    _fill_internal_states(q, effects)
    q[KINKS] = float(np.any(q[[COULOMB, STRIBECK, DRAG, BRISTLE, FLUCTUATION]]))


def _check_friction(q: NDArray[np.float64], which: str, effect: str) -> None:
    if q[HERTZ] == 0.0 and q[COULOMB] == 0.0:
        raise ConfigError(
            f"there is no dry friction {which}",
            where=f"backends.simulated.undeclared, {effect}",
            remedy="mount a jewel, or add coulomb_friction or hertz_friction",
        )


def _check_mode(q: NDArray[np.float64], coupling: float) -> None:
    lowest_hz = abs(coupling) * q[OMEGA_SQUARED] ** 0.5 / pi
    if q[MODE_OMEGA] <= 2 * pi * lowest_hz:
        raise ConfigError(
            f"a second mode of strength {coupling} runs away",
            where="backends.simulated.undeclared, second_mode",
            why=f"it must be faster than {lowest_hz:.4g} Hz on this specimen",
            remedy="couple it less, or raise its frequency_hz",
        )


def _fill_internal_states(q: NDArray[np.float64], effects: HiddenEffects) -> None:
    stiffness = q[OMEGA_SQUARED]
    if relaxation := first(effects, MemoryRelaxation):
        q[RELAXATION] = relaxation.strength * stiffness
        q[RELAXATION_RATE] = 1 / relaxation.tau_s
    if bristle := first(effects, MemoryBristle):
        q[BRISTLE] = bristle.strength
        q[BRISTLE_REACH] = bristle.reach_rad
    if amplitude := first(effects, MemoryAmplitude):
        q[AMPLITUDE] = amplitude.strength * stiffness
        q[AMPLITUDE_RATE] = 1 / amplitude.tau_s
    if gap := first(effects, BreathingGap):
        q[GAP] = gap.strength
        q[GAP_OMEGA] = 2 * pi * gap.frequency_hz
        q[GAP_DAMPING] = 2 * gap.decay_per_s
    if mode := first(effects, SecondMode):
        q[MODE] = mode.strength * stiffness
        q[MODE_OMEGA] = 2 * pi * mode.frequency_hz
        q[MODE_DAMPING] = 2 * mode.decay_per_s
        q[MODE_ORDER] = mode.order
        _check_mode(q, mode.strength)


@kernel
def _wave_sum(tau: float, q: NDArray[np.float64], place: int) -> float:
    """Of unit variance over many shots; place: slot of the first wave."""
    x = 0.0
    for k in range(FLUCTUATION_WAVES):
        x += cos(q[place + 2 * k] * tau + q[place + 2 * k + 1])
    return float(x * (2.0 / FLUCTUATION_WAVES) ** 0.5)


@kernel
def stiffness_change(tau: float, q: NDArray[np.float64]) -> float:
    """What omega_nat^2 has more than its value in slot 1, by drift and fluctuation, rad^2/s^2."""
    shift = 0.0
    since = tau - q[DRIFT_FROM]
    if q[DRIFT] != 0.0 and since > 0.0:
        if q[DRIFT_TAU] > 0.0:
            since = q[DRIFT_TAU] * (1.0 - exp(-since / q[DRIFT_TAU]))
        shift = q[DRIFT] * since
    if q[UNSTEADY] != 0.0:
        shift += q[UNSTEADY] * _wave_sum(tau, q, UNSTEADY_WAVES)
    return float(shift * (2.0 * np.sqrt(q[OMEGA_SQUARED]) + shift))


@kernel
def smooth(tau: float, phi: float, phi_dot: float, sine: float, cosine: float, q: NDArray[np.float64]) -> float:
    """Sum of the smooth hidden torques, rad/s^2."""
    change = stiffness_change(tau, q)
    soft = q[ANHARMONICITY] * (1.0 - cosine)
    total = -(change * (1.0 - soft) - q[OMEGA_SQUARED] * soft) * sine
    total -= q[TORSION] * q[OMEGA_SQUARED] * phi + q[ANGLE_DAMPING] * phi * phi * phi_dot
    return float(total + q[BIAS])


@kernel
def _fluctuation(tau: float, q: NDArray[np.float64]) -> float:
    """Factor on dry friction: lognormal, of mean 1 over many shots."""
    s = q[FLUCTUATION]
    return exp(s * _wave_sum(tau, q, WAVES) - 0.5 * s * s)


@kernel
def opposing(tau: float, dry: float, speed: float, q: NDArray[np.float64]) -> float:
    """Level of all torques that oppose the motion, rad/s^2, with Stribeck's factor, fluctuation and drag.

    dry: level of the declared dry friction; speed: of phi in the direction of the motion, so that the result is
    analytic between turning points.
    """
    level = dry + q[COULOMB]
    if q[STRIBECK] != 0.0:
        level *= 1.0 + q[STRIBECK] * exp(min(-speed / q[STRIBECK_SPEED], 30.0))
    if q[FLUCTUATION] != 0.0:
        level *= _fluctuation(tau, q)
    return float(level + q[DRAG] * speed * speed)
