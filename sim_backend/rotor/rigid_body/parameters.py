"""From a rotor to the parameters of its five equations of motion: geometry, defects, friction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.constants import mu_0

from drivers.errors import ConfigError
from sim_backend.hidden_effects import internal_states, torques
from sim_backend.hidden_effects.listing import HiddenEffects
from sim_backend.rotor.rotor import BodyDesign, Rotor

from .acceleration import (
    ANCHOR,
    ARM,
    BACK,
    BODY_MOMENT,
    DAMPING,
    HERTZ,
    INERTIA,
    JEWEL,
    LINK,
    MASS,
    MU,
    SIDE_DAMPING,
    SLOTS,
    SLOWEST_SLIP,
    SLOWEST_SPIN,
    STATOR,
    STATOR_MOMENT,
    WEIGHT,
)

# Speeds that regularise a contact at rest: far below those of a side mode of 1 deg (10 mm/s) and of the main mode
# (1000 rad/s), and large enough that a contact at rest does not need steps much shorter than a sample.
REST_SLIP_M_PER_S = 2e-3
REST_SPIN_RAD_PER_S = 3e-4
SINGLE_AXIS = (torques.__name__, internal_states.__name__)  # modules of the effects that act about the main axis only


def about_v(angle_rad: float) -> NDArray[np.float64]:
    """(3, 3) float64 rotation about v, the axis of all tilts (fig:math_description_angle_defects)."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def body_parameters(rotor: Rotor, conductance: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
    """The parameters (SLOTS,) of a rotor with a body, see `acceleration`.

    conductance: (3, 3) float64, T^2/(A V), sum over the coils of b b^T Re(1/Z) in u, v, w; None: no back-action.
    """
    body, defects = _body(rotor), _body(rotor).defects
    p = np.zeros(SLOTS)
    p[JEWEL] = float(rotor.variant == "jewel")
    p[MASS] = body.mass_kg
    p[INERTIA] = rotor.inertia_kg_m2
    p[ARM] = body.radius_m
    p[LINK] = body.cup_radius_m - body.radius_m if p[JEWEL] else body.thread_length_m
    p[ANCHOR : ANCHOR + 3] = _anchor_m(rotor)
    p[STATOR : STATOR + 2] = defects.stator_offset_m
    stator_am2 = 4 * np.pi * body.distance_m**3 * rotor.b_0_t / mu_0
    p[STATOR_MOMENT : STATOR_MOMENT + 3] = stator_am2 * about_v(defects.stator_tilt_rad) @ [-1.0, 0.0, 0.0]
    p[BODY_MOMENT : BODY_MOMENT + 3] = rotor.m_r_am2 * about_v(defects.rotor_tilt_rad) @ [1.0, 0.0, 0.0]
    p[WEIGHT : WEIGHT + 3] = body.mass_kg * rotor.rotation.T @ body.gravity_m_per_s2
    p[DAMPING] = rotor.lambda_per_s
    p[SIDE_DAMPING] = body.side_damping_per_s
    p[MU] = friction_coefficient(rotor)
    p[HERTZ] = rotor.contact * body.hertz_m_per_n13
    p[SLOWEST_SLIP] = REST_SLIP_M_PER_S
    p[SLOWEST_SPIN] = REST_SPIN_RAD_PER_S
    if conductance is not None:
        p[BACK : BACK + 9] = conductance.ravel()
    return p


def friction_coefficient(rotor: Rotor) -> float:
    """mu from T_f/I at phi = 0 and the attraction at the derived distance (eq:tf, eq:fm(phi)); 0 for a thread."""
    body = _body(rotor)
    force_n = 3 * rotor.m_r_am2 * rotor.b_0_t / body.distance_m
    if body.hertz_m_per_n13 == 0.0:
        return 0.0
    radius_m = rotor.contact * body.hertz_m_per_n13 * force_n ** (1 / 3)
    return float(rotor.tf_over_i_rad_per_s2 * rotor.inertia_kg_m2 / (3 / 16 * np.pi * radius_m * force_n))


def _body(rotor: Rotor) -> BodyDesign:
    assert rotor.body is not None
    return rotor.body


def _anchor_m(rotor: Rotor) -> NDArray[np.float64]:
    """The anchor A, (3,), m: above the rotor for a thread; the centre of the tilted cup for a jewel."""
    body = _body(rotor)
    if rotor.variant == "thread":
        return np.array([0.0, 0.0, body.distance_m + body.radius_m + body.thread_length_m])
    centre = np.array([0.0, 0.0, body.distance_m + body.cup_radius_m - body.radius_m])
    heights_m = {"contact": body.distance_m - body.radius_m, "rotor": body.distance_m, "stator": 0.0}
    pivot = np.array([0.0, 0.0, heights_m[body.defects.jewel_tilt_pivot]])
    return np.asarray(pivot + about_v(body.defects.jewel_tilt_rad) @ (centre - pivot))


def refuse(hidden_effects: HiddenEffects) -> None:
    """Raise ConfigError for hidden torques, which exist only for one degree of freedom."""
    names = [effect.id for effect in hidden_effects if type(effect).__module__ in SINGLE_AXIS]
    if names:
        raise ConfigError(
            f"a rigid_body rotor knows no undeclared {', '.join(names)}",
            where="backends.simulated.undeclared",
            why="undeclared torques act about the main axis alone",
            remedy="mount a resonator with rotor.model = 'single_axis', or leave them out",
        )
