"""Hidden torques, per inertia: terms on the right-hand side of phi'' = ..., with w = 2 pi f_nat.

phi: angle of the rotor, rad; a prime is a time derivative.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from sim_backend.section import NonNegative

from .base import Effect, Time


class CoulombFriction(Effect):
    """Coulomb friction: the term is -sgn(phi') a."""

    UNIT = "rad/s^2"
    id: Literal["coulomb_friction"]
    strength: NonNegative


class HertzFriction(Effect):
    """Friction of a Hertz contact: -sgn(phi') a cos^(4/3) phi, added to the specimen's own (eq:tf(phi))."""

    UNIT = "rad/s^2"
    id: Literal["hertz_friction"]
    strength: NonNegative


class StribeckFriction(Effect):
    """All dry friction is multiplied by 1 + s exp(-|phi'| / v_s)."""

    UNIT = "1"
    id: Literal["stribeck_friction"]
    strength: Annotated[float, Field(ge=-1, le=10, allow_inf_nan=False)]
    v_s_rad_per_s: Annotated[float, Field(ge=0.1, allow_inf_nan=False)]


class FrictionFluctuation(Effect):
    """All dry friction is multiplied by exp(s x - s^2 / 2), whose mean is 1; x is a random process, new in every shot.

    x is normal with unit variance and the correlation exp(-|t| / tau_s), as a sum of FLUCTUATION_WAVES waves.  A rotor
    that sticks is held by the friction of the moment at which it came to rest.
    """

    UNIT = "1"
    id: Literal["friction_fluctuation"]
    strength: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
    tau_s: Annotated[float, Field(ge=0.01, le=100, allow_inf_nan=False)]


class QuadraticDrag(Effect):
    """Quadratic drag: the term is -b phi' |phi'|."""

    UNIT = "1/rad"
    id: Literal["quadratic_drag"]
    strength: Annotated[float, Field(ge=0, le=10, allow_inf_nan=False)]


class AngleDependentDamping(Effect):
    """Damping -2 kappa phi^2 phi', phi in rad; a negative kappa weakens the viscous damping at large angles."""

    UNIT = "1/s"
    id: Literal["angle_dependent_damping"]


class RestoringAnharmonicity(Effect):
    """The restoring torque is multiplied by 1 - beta (1 - cos phi)."""

    UNIT = "1"
    id: Literal["restoring_anharmonicity"]
    strength: Annotated[float, Field(gt=-0.5, lt=0.5, allow_inf_nan=False)]


class TorsionStiffness(Effect):
    """Torsion of the bearing: the term is -k w^2 phi."""

    UNIT = "1"
    id: Literal["torsion_stiffness"]
    strength: Annotated[float, Field(gt=-0.5, le=10, allow_inf_nan=False)]


class BiasTorque(Effect):
    """A constant torque t, independent of phi; the rotor rests where the restoring torque balances it."""

    UNIT = "rad/s^2"
    id: Literal["bias_torque"]


class FrequencyFluctuation(Effect):
    """f_nat has `strength` x more than its mean; x is a random process, new in every shot, as of a friction that
    fluctuates."""

    UNIT = "Hz"
    id: Literal["frequency_fluctuation"]
    strength: Annotated[float, Field(ge=0, le=10, allow_inf_nan=False)]
    tau_s: Annotated[float, Field(ge=0.01, le=100, allow_inf_nan=False)]


class FrequencyDrift(Effect):
    """f_nat drifts from the first RX sample on at the rate `strength`.

    With tau_s the drift saturates as strength tau (1 - exp(-t/tau)).  Every shot starts again from the f_nat that its
    truth states.
    """

    UNIT = "Hz/s"
    id: Literal["frequency_drift"]
    strength: Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False)]
    tau_s: Time | None = None
