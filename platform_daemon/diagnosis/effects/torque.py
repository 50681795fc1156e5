"""Torque effects: the terms of estimation/terms that the declared models lack, with their sign rules."""

from __future__ import annotations

from platform_daemon.estimation.models import RingDownModel
from platform_daemon.estimation.terms import TERMS, TorqueTerm

from .base import Candidate, Effect

_LONGER, _AMPLITUDE, _TURN, _BIAS = "longer_window", "second_amplitude", "turn_90_deg", "bias_field"
_EFFECTS = (
    Effect("coulomb_friction", "rad/s^2", 1, (_LONGER, _AMPLITUDE), "dry friction in joints and fibres: Kanj 2022"),
    Effect("hertz_friction", "rad/s^2", 1, (_LONGER, _AMPLITUDE), "eq:Jewel_ODE_norm, on a thread"),
    Effect("quadratic_drag", "1/rad", 1, (_AMPLITUDE, _LONGER), "inertial air drag"),
    Effect("angle_dependent_damping", "1/s", 0, (_AMPLITUDE, _LONGER), "Kanj 2022; streaming, gap-dependent eddies"),
    Effect("restoring_anharmonicity", "1", 0, (_AMPLITUDE, _TURN), "thread stretch, octupole of the magnets"),
    Effect("torsion_stiffness", "1", 1, (_AMPLITUDE, _BIAS), "stiffness of the thread"),
    Effect("bias_torque", "rad/s^2", 0, (_AMPLITUDE, _BIAS), "twisted thread, eccentric weight"),
    Effect("frequency_drift", "1/s", 0, (_LONGER,), "heating, creep of the magnets' distance"),
)
_CONTACT_ONLY = {"hertz_friction"}


def torque_candidates(model: RingDownModel) -> list[Candidate]:
    """Terms that the model does not contain already, in the order of the list."""
    found = []
    for effect in _EFFECTS:
        term = TERMS[effect.id]
        if term not in model.terms:
            found.append(Candidate(effect, term=term))
    return found + _stribeck(model)


def _stribeck(model: RingDownModel) -> list[Candidate]:
    """Only where there is friction; its velocity scale is hidden: a grid in fractions of the natural velocity."""
    term: TorqueTerm = TERMS["stribeck_friction"]
    if "hertz_friction" not in {t.name for t in model.terms} or term in model.terms:
        return []
    effect = Effect("stribeck_friction", "1", 0, (_LONGER, _AMPLITUDE), "Stribeck curve")
    return [Candidate(effect, term=term, hidden=(scale,)) for scale in (10.0, 20.0, 40.0, 80.0, 160.0, 320.0)]
