"""Torque effects: the terms of estimation/physics/torques that the declared models lack, with their sign rules."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from platform_daemon.estimation import TERMS, RingDownModel, TorqueTerm

from .effect import Candidate, Detail, Effect

_LONGER, _AMPLITUDE, _TURN, _BIAS = "longer_window", "second_amplitude", "turn_90_deg", "bias_field"
_KANJ = "Kanj et al. 2022, losses of magneto-mechanical resonators"
EFFECTS = (
    Effect(
        "coulomb_friction", "rad/s^2", 1, (_LONGER, _AMPLITUDE),
        "lambda(window) rises as 1/phi; v1 in amplitude", f"dry friction in joints and fibres: {_KANJ}",
    ),
    Effect(
        "hertz_friction", "rad/s^2", 1, (_LONGER, _AMPLITUDE),
        "as dry friction, weaker at large angles", "eq:Jewel_ODE_norm, of a jewel bearing",
    ),
    Effect(
        "quadratic_drag", "1/rad", 1, (_AMPLITUDE, _LONGER),
        "lambda(window) falls with the amplitude", "inertial drag of air; Nelson and Olsson 1986",
    ),
    Effect(
        "angle_dependent_damping", "1/s", 0, (_AMPLITUDE, _LONGER),
        "lambda(window) follows phi^2", f"streaming, eddy currents that depend on the gap: {_KANJ}",
    ),
    Effect(
        "restoring_anharmonicity", "1", 0, (_AMPLITUDE, _TURN),
        "f_nat(window) follows phi^2; u2 in amplitude", "stretch of the thread, higher moments of the magnets",
    ),
    Effect(
        "torsion_stiffness", "1", 1, (_AMPLITUDE, _BIAS),
        "as restoring anharmonicity -k/3, with f_nat shifted", "torsion of the thread",
        "most of a torsion is a shift of f_nat; f_nat_hz is that of the declared sine term",
    ),
    Effect(
        "bias_torque", "rad/s^2", 0, (_AMPLITUDE, _BIAS),
        "v2, u3 and u1: the swing is not symmetric", "twisted thread, eccentric weight",
    ),
)  # fmt: skip
DRIFT = Effect(
    "frequency_drift", "Hz/s", 0, (_LONGER,), "f_nat(window) follows the time, whatever the amplitude",
    "heating, creep of the magnets' distance",
)  # fmt: skip
STRIBECK = Effect(
    "stribeck_friction", "1", 0, (_LONGER, _AMPLITUDE), "T_f(window) rises as the motion dies", "Stribeck 1902",
)  # fmt: skip
STRIBECK_OF_PENDULUM = Effect(
    "stribeck_friction", "rad/s^2", 1, (_LONGER, _AMPLITUDE),
    "lambda(window) rises faster than 1/phi as the motion dies", "friction that falls with the speed: Stribeck 1902",
)  # fmt: skip
CUBIC = Effect(
    "cubic_restoring", "1", 0, (_AMPLITUDE,), "f_nat(window) follows phi^2",
    "a spring that stiffens, a stretched wire: Duffing 1918",
)  # fmt: skip
_STRIBECK_SPEEDS = (5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0)  # rad/s
_SLOWEST, _FASTEST = 0.05, 2.0  # velocity scales of a pendulum's friction, of its peak speed
_OFTEN = 0.3  # of it: where the search begins
SPRINGS = frozenset({"restoring_anharmonicity", "torsion_stiffness", "cubic_restoring"})  # they go with f_nat^2
_LARGEST = {"restoring_anharmonicity": 1.0, "torsion_stiffness": 1.0, "cubic_restoring": 0.5}
_OFTEN_SETTLED, _SLOW_SETTLING, _FAST_SETTLING = 4.0, 1.0, 40.0  # time constants in a window
_DRIFT = 0.2  # of f_nat over the window: beyond that it is no drift


def torque_candidates(model: RingDownModel, *, jewel_law: bool = True) -> list[Candidate]:
    """Terms without a hidden scale that the model does not contain already, in the order of the list.

    jewel_law: the Hertz contact's law holds at the angles of these shots.
    """
    unfit = {t.name for t in model.terms} | (set() if jewel_law else {"hertz_friction"})
    return [Candidate(effect, term=TERMS[effect.id]) for effect in EFFECTS if effect.id not in unfit]


def pendulum_candidates(model: RingDownModel, fastest_rad_per_s: float, seconds: float) -> list[Candidate]:
    """Torques on a swing whose angle is read: no Hertz contact, but a friction that falls with the speed, and springs.

    fastest_rad_per_s: peak speed of the swing; seconds: length of its window.
    """
    plain = [*torque_candidates(model, jewel_law=False), Candidate(CUBIC, term=TERMS["cubic_restoring"])]
    plain = [replace(c, largest=_LARGEST.get(c.effect.id, c.largest)) for c in plain if c.term not in model.terms]
    found = [*plain, replace(drift_candidate(), largest=_DRIFT / seconds)]
    found.append(settling_candidate(seconds))
    if TERMS["stribeck_coulomb_friction"] not in model.terms:
        bounds = _SLOWEST * fastest_rad_per_s, _FASTEST * fastest_rad_per_s
        found.append(_of_pendulum(_OFTEN * fastest_rad_per_s, *bounds))
    return found


def _of_pendulum(speed: float, slowest: float, fastest: float) -> Candidate:
    """Friction that falls with the speed, at one velocity scale in rad/s between two limits."""

    def at_scale(other: float) -> Candidate:
        return _of_pendulum(other, slowest, fastest)

    term = TERMS["stribeck_coulomb_friction"]
    limits = slowest, fastest
    return Candidate(STRIBECK_OF_PENDULUM, term=term, hidden=(speed,), scale_limits=limits, at_scale=at_scale)


def drift_candidate() -> Candidate:
    """f_nat that moves through the window."""
    return Candidate(
        DRIFT,
        term=TERMS["frequency_drift"],
        public=lambda q, sd, f_nat: (q * f_nat, sd * f_nat),
        f_nat_course=lambda time_s: time_s,
    )


def settling_candidate(seconds: float) -> Candidate:
    """f_nat that moves at first and comes to rest within a window of this length; its rate at the first sample."""
    return _settling(_OFTEN_SETTLED / seconds, _SLOW_SETTLING / seconds, _FAST_SETTLING / seconds)


def _settling(rate: float, slowest: float, fastest: float) -> Candidate:
    """At one rate in 1/s between two limits."""

    def at_scale(other: float) -> Candidate:
        return _settling(other, slowest, fastest)

    return Candidate(
        DRIFT, Detail(tau_s=1.0 / rate), term=TERMS["frequency_settling"], hidden=(rate,),
        public=lambda q, sd, f_nat: (q * f_nat, sd * f_nat), scale_limits=(slowest, fastest), at_scale=at_scale,
        f_nat_course=lambda time_s: -np.expm1(-rate * time_s) / rate,
    )  # fmt: skip


def stribeck_candidates(model: RingDownModel) -> list[Candidate]:
    """Only where there is Hertz friction; its velocity scale is hidden."""
    term: TorqueTerm = TERMS["stribeck_friction"]
    if "hertz_friction" not in {t.name for t in model.terms} or term in model.terms:
        return []
    return [_stribeck(term, speed) for speed in _STRIBECK_SPEEDS]


def _stribeck(term: TorqueTerm, speed: float) -> Candidate:
    """At one velocity scale in rad/s."""

    def near(share: float) -> list[Candidate]:
        return [_stribeck(term, speed * 2.0 ** (share * step)) for step in (-0.6, -0.3, 0.0, 0.3, 0.6)]

    return Candidate(STRIBECK, term=term, hidden=(speed,), of="tf_over_i_rad_per_s2", near=near)
