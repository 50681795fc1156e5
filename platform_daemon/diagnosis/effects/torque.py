"""Torque effects: the terms of estimation/physics/torques that the declared models lack, with their sign rules."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.torque_term import TorqueTerm
from platform_daemon.estimation.physics.torques import FROM_PACKAGES, TERMS

from .effect import Candidate, Detail, Effect

_LIMITS = THRESHOLDS.effects
_LONGER, _AMPLITUDE, _TURN, _BIAS = "longer_window", "second_amplitude", "turn_90_deg", "bias_field"
_KANJ = "Kanj et al. 2022, losses of magneto-mechanical resonators"
EFFECTS = (
    Effect(
        id="coulomb_friction",
        unit="rad/s^2",
        sign=1,
        separates=(_LONGER, _AMPLITUDE),
        signature="lambda(window) rises as 1/phi; v1 in amplitude",
        source=f"dry friction in joints and fibres: {_KANJ}",
    ),
    Effect(
        id="hertz_friction",
        unit="rad/s^2",
        sign=1,
        separates=(_LONGER, _AMPLITUDE),
        signature="as dry friction, weaker at large angles",
        source="eq:Jewel_ODE_norm, of a jewel bearing",
    ),
    Effect(
        id="quadratic_drag",
        unit="1/rad",
        sign=1,
        separates=(_AMPLITUDE, _LONGER),
        signature="lambda(window) falls with the amplitude",
        source="inertial drag of air; Nelson and Olsson 1986",
    ),
    Effect(
        id="angle_dependent_damping",
        unit="1/s",
        sign=0,
        separates=(_AMPLITUDE, _LONGER),
        signature="lambda(window) follows phi^2",
        source=f"streaming, eddy currents that depend on the gap: {_KANJ}",
    ),
    Effect(
        id="restoring_anharmonicity",
        unit="1",
        sign=0,
        separates=(_AMPLITUDE, _TURN),
        signature="f_nat(window) follows phi^2; u2 in amplitude",
        source="stretch of the thread, higher moments of the magnets",
    ),
    Effect(
        id="torsion_stiffness",
        unit="1",
        sign=1,
        separates=(_AMPLITUDE, _BIAS),
        signature="as restoring anharmonicity -k/3, with f_nat shifted",
        source="torsion of the thread",
        absorbed="most of a torsion is a shift of f_nat; f_nat_hz is that of the declared sine term",
    ),
    Effect(
        id="bias_torque",
        unit="rad/s^2",
        sign=0,
        separates=(_AMPLITUDE, _BIAS),
        signature="v2, u3 and u1: the swing is not symmetric",
        source="twisted thread, eccentric weight",
    ),
)
DRIFT = Effect(
    id="frequency_drift",
    unit="Hz/s",
    sign=0,
    separates=(_LONGER,),
    signature="f_nat(window) follows the time, whatever the amplitude",
    source="heating, creep of the magnets' distance",
)
STRIBECK = Effect(
    id="stribeck_friction",
    unit="1",
    sign=0,
    separates=(_LONGER, _AMPLITUDE),
    signature="T_f(window) rises as the motion dies",
    source="Stribeck 1902",
)
STRIBECK_OF_PENDULUM = Effect(
    id="stribeck_friction",
    unit="rad/s^2",
    sign=1,
    separates=(_LONGER, _AMPLITUDE),
    signature="lambda(window) rises faster than 1/phi as the motion dies",
    source="friction that falls with the speed: Stribeck 1902",
)
DAHL = Effect(
    id="dahl_friction",
    unit="rad/s^2",
    sign=1,
    separates=(_LONGER, _AMPLITUDE),
    signature="as dry friction, and f_nat(window) rises as the motion dies",
    source="a contact is a spring before it slides: Dahl 1968, Canudas de Wit et al. 1995",
)
CUBIC = Effect(
    id="cubic_restoring",
    unit="1",
    sign=0,
    separates=(_AMPLITUDE,),
    signature="f_nat(window) follows phi^2",
    source="a spring that stiffens, a stretched wire: Duffing 1918",
)
POWER = Effect(
    id="power_restoring",
    unit="1",
    sign=0,
    separates=(_AMPLITUDE,),
    signature="f_nat(window) follows a power of the amplitude",
    source="a stop, a hull in waves, a spring of no single power: roll restoring of ships, ITTC 7.5-02-07-04.5",
)
# They go with f_nat^2.
SPRINGS = frozenset({"restoring_anharmonicity", "torsion_stiffness", "cubic_restoring", "power_restoring"})
_LARGEST = {
    "restoring_anharmonicity": _LIMITS.largest_anharmonicity,
    "torsion_stiffness": _LIMITS.largest_torsion,
    "cubic_restoring": _LIMITS.largest_cubic,
}


def torque_candidates(model: RingDownModel, *, jewel_law: bool = True) -> list[Candidate]:
    """Terms without a hidden scale that the model does not contain already, in the order of the list.

    jewel_law: the Hertz contact's law holds at the angles of these shots.
    """
    unfit = {t.name for t in model.terms} | (set() if jewel_law else {"hertz_friction"})
    declared = [Candidate(effect, term=TERMS[effect.id]) for effect in EFFECTS if effect.id not in unfit]
    own = [term for term in FROM_PACKAGES if term.name not in unfit and len(term.coefficients) == 1]
    return [*declared, *(Candidate(_effect_of(term), term=term) for term in own)]


def _effect_of(term: TorqueTerm) -> Effect:
    """The effect of a term of another package."""
    return Effect(
        id=term.name,
        unit=term.coefficients[0].unit,
        sign=1 if term.loses_energy else 0,
        separates=(_AMPLITUDE, _LONGER),
        signature="as its equation says",
        source=f"the torque term of {term.function.__module__}",
    )


def pendulum_candidates(
    model: RingDownModel, fastest_rad_per_s: float, seconds: float, largest_rad: float
) -> list[Candidate]:
    """Torques on a swing whose angle is read: no Hertz contact, but a friction that falls with the speed, and springs.

    fastest_rad_per_s: peak speed of the swing; seconds: length of its window; largest_rad: its amplitude.
    """
    plain = [*torque_candidates(model, jewel_law=False), Candidate(CUBIC, term=TERMS["cubic_restoring"])]
    limits = largest_springs(largest_rad)
    plain = [replace(c, largest=limits.get(c.effect.id, c.largest)) for c in plain if c.term not in model.terms]
    found = [*plain, replace(drift_candidate(), largest=_LIMITS.largest_drift / seconds)]
    found.append(settling_candidate(seconds))
    if TERMS["power_restoring"] not in model.terms:
        found.append(_power(_LIMITS.first_exponent, largest_rad))
    if TERMS["stribeck_coulomb_friction"] not in model.terms:
        bounds = _LIMITS.slowest_scale * fastest_rad_per_s, _LIMITS.fastest_scale * fastest_rad_per_s
        found.append(_of_pendulum(_LIMITS.first_scale * fastest_rad_per_s, *bounds))
    if TERMS["dahl_friction"] not in model.terms:
        w = fastest_rad_per_s / (2.0 * math.sin(0.5 * largest_rad))
        least, first, greatest = (share * largest_rad for share in _LIMITS.displacement_shares)
        found.append(_dahl(least, first, greatest, w))
    return found


def largest_springs(largest_rad: float) -> dict[str, float]:
    """Strengths beyond which a term is another spring, by effect, for swings up to this amplitude in rad.

    Of the restoring torque a term that grows with the square of the amplitude beside it is as large a share in a small
    swing only with a greater strength. Larger swings than 1 rad have the limits at 1 rad.
    """
    as_share = max(1.0, largest_rad**-2)
    return {name: limit if name == "torsion_stiffness" else as_share * limit for name, limit in _LARGEST.items()}


def _of_pendulum(speed: float, slowest: float, fastest: float) -> Candidate:
    """Friction that falls with the speed, at one velocity scale in rad/s between two limits."""

    def at_scale(other: float) -> Candidate:
        return _of_pendulum(other, slowest, fastest)

    term = TERMS["stribeck_coulomb_friction"]
    limits = slowest, fastest
    return Candidate(STRIBECK_OF_PENDULUM, term=term, hidden=(speed,), scale_limits=limits, at_scale=at_scale)


def _dahl(least_rad: float, displacement_rad: float, greatest_rad: float, w: float) -> Candidate:
    """Dry friction that builds up over an angle between two limits, by a contact no stiffer than the pendulum."""

    def at_scale(other: float) -> Candidate:
        return _dahl(least_rad, other, greatest_rad, w)

    return Candidate(
        DAHL,
        term=TERMS["dahl_friction"],
        hidden=(displacement_rad,),
        largest=_LIMITS.stiffest_contact * displacement_rad * w**2,
        scale_limits=(least_rad, greatest_rad),
        at_scale=at_scale,
    )


def _power(exponent: float, angle_rad: float) -> Candidate:
    """A spring of one power of the deflection; its strength is its share of a plain spring's torque at an angle."""

    def at_scale(other: float) -> Candidate:
        return _power(other, angle_rad)

    return Candidate(
        POWER,
        term=TERMS["power_restoring"],
        hidden=(exponent, angle_rad),
        largest=_LIMITS.largest_cubic,
        scale_limits=(_LIMITS.least_exponent, _LIMITS.greatest_exponent),
        at_scale=at_scale,
    )


def drift_candidate() -> Candidate:
    """f_nat that moves through the window."""
    return Candidate(
        DRIFT,
        term=TERMS["frequency_drift"],
        public=lambda q, sd, f_nat: (q * f_nat, sd * f_nat),
        f_nat_course=lambda time_s: time_s,
    )


def settling_candidate(seconds: float, first: float = _LIMITS.first_settling) -> Candidate:
    """f_nat that moves at first and comes to rest within a window of this length; its rate at the first sample.

    first: time constants per window at which its search begins.
    """
    return _settling(first / seconds, _LIMITS.slowest_settling / seconds, _LIMITS.fastest_settling / seconds)


def _settling(rate: float, slowest: float, fastest: float) -> Candidate:
    """At one rate in 1/s between two limits."""

    def at_scale(other: float) -> Candidate:
        return _settling(other, slowest, fastest)

    return Candidate(
        DRIFT,
        Detail(tau_s=1.0 / rate),
        term=TERMS["frequency_settling"],
        hidden=(rate,),
        public=lambda q, sd, f_nat: (q * f_nat, sd * f_nat),
        scale_limits=(slowest, fastest),
        at_scale=at_scale,
        f_nat_course=lambda time_s: -np.expm1(-rate * time_s) / rate,
    )


def stribeck_candidates(model: RingDownModel) -> list[Candidate]:
    """Only where there is Hertz friction; its velocity scale is hidden."""
    term: TorqueTerm = TERMS["stribeck_friction"]
    if "hertz_friction" not in {t.name for t in model.terms} or term in model.terms:
        return []
    return [_stribeck(term, speed) for speed in _LIMITS.stribeck_rad_per_s]


def _stribeck(term: TorqueTerm, speed: float) -> Candidate:
    """At one velocity scale in rad/s."""

    def near(share: float) -> list[Candidate]:
        return [_stribeck(term, speed * 2.0 ** (share * step)) for step in _LIMITS.stribeck_moves]

    return Candidate(STRIBECK, term=term, hidden=(speed,), of="tf_over_i_rad_per_s2", near=near)
