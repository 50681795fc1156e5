"""Names of the declared ring-down models and of the torque terms that any of them can have in addition to its own.

The names are data that loads at once.  The models and terms themselves are compiled code of
`platform_daemon.estimation`; a test compares the two.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import entry_points

DECLARED_MODELS = {
    "thread": ("magnetic_restoring", "viscous_damping"),
    "jewel": ("magnetic_restoring", "viscous_damping", "hertz_friction"),
    "jewel_constant_friction": ("magnetic_restoring", "viscous_damping", "coulomb_friction"),
    "undamped": ("magnetic_restoring",),
    "undamped_small_angle": ("linear_restoring",),
    "thread_small_angle": ("linear_restoring", "viscous_damping"),
    "jewel_small_angle": ("linear_restoring", "viscous_damping", "coulomb_friction"),
}
"""By name of a declared model its own torque terms."""
TORQUE_TERMS = {
    "magnetic_restoring": (),
    "viscous_damping": ("lambda_per_s",),
    "hertz_friction": ("tf_over_i_rad_per_s2",),
    "coulomb_friction": ("coulomb_rad_per_s2",),
    "linear_restoring": (),
    "quadratic_drag": ("quadratic_drag_per_rad",),
    "angle_dependent_damping": ("kappa_per_s",),
    "restoring_anharmonicity": ("anharmonicity",),
    "torsion_stiffness": ("torsion_stiffness",),
    "bias_torque": ("bias_rad_per_s2",),
    "stribeck_friction": ("stribeck_rad_per_s2", "stribeck_speed_rad_per_s"),
    "stribeck_coulomb_friction": ("stribeck_coulomb_rad_per_s2", "stribeck_coulomb_speed_rad_per_s"),
    "cubic_restoring": ("cubic_restoring",),
    "frequency_drift": ("frequency_drift_per_s",),
    "frequency_settling": ("frequency_settling_per_s", "frequency_settling_rate_per_s"),
    "power_restoring": ("power_restoring", "power_restoring_exponent", "power_restoring_angle_rad"),
    "dahl_friction": ("dahl_rad_per_s2", "dahl_displacement_rad"),
}
"""By name of a torque term the public names of its coefficients: first its strength, then scales that stay hidden."""


@cache
def torque_terms() -> tuple[str, ...]:
    """The names of all torque terms, those of other packages (estimation/physics/torques/own_terms.py) included."""
    own = sorted(entry.name for entry in entry_points(group="platform_daemon.torque_terms"))
    return tuple(dict.fromkeys((*TORQUE_TERMS, *own)))


def check_model_name(name: str) -> None:
    """Check that a name such as `thread+quadratic_drag` is a declared model, or one with further torque terms.

    Raises ValueError for an unknown model, with the known ones, for an unknown term, and for a term that the model
    contains already.
    """
    declared, *further = name.split("+")
    if declared not in DECLARED_MODELS:
        raise ValueError(f"unknown variant {declared!r}: expected one of {', '.join(DECLARED_MODELS)}")
    unknown = [term for term in further if term not in torque_terms()]
    if unknown:
        raise ValueError(f"unknown torque term {unknown[0]!r}: expected one of {', '.join(torque_terms())}")
    terms = [*DECLARED_MODELS[declared], *further]
    if len(set(terms)) < len(terms):
        raise ValueError(f"model {name!r} contains a torque term twice")
