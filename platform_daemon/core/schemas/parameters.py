"""The parameters of a resonator: the one table of names, symbols, units, and how they are shown.

Names are public keys of every JSON form and hold their SI unit; estimation and the torque terms declare the same names
and units, which a test compares.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

_DEGREES = math.degrees(1)


@dataclass(frozen=True)
class ParameterDefinition:
    """One parameter.

    Attributes:
        name: public key.
        symbol: as plain text; mathtext: for figures, as matplotlib sets it.
        unit: SI, as text; "1": none.
        display_unit: in which people read it; display_factor: from SI to it.
        description: what it is, and where the paper defines it.
    """

    name: str
    symbol: str
    mathtext: str
    unit: str
    display_unit: str
    display_factor: float
    description: str

    @property
    def heading(self) -> str:
        """Of a column: symbol / unit."""
        return f"{self.symbol} / {self.display_unit}" if self.display_unit else self.symbol

    @property
    def axis_label(self) -> str:
        """The same for figures."""
        return f"{self.mathtext} / {self.display_unit}" if self.display_unit else self.mathtext


_P = ParameterDefinition
_TABLE = (
    _P("f_nat_hz", "f_nat", "$f_{nat}$", "Hz", "Hz", 1.0, "natural frequency of small swings (eq:omega_nat)"),
    _P("m_r_am2", "m_r", "$m_r$", "A m^2", "mAm²", 1e3, "magnetic moment of the rotor (eq:m_r)"),
    _P("lambda_per_s", "λ", "λ", "1/s", "s⁻¹", 1.0, "viscous damping, ω/(2 Q) (eq:lambda)"),
    _P("tf_over_i_rad_per_s2", "T_f/I", "$T_f/I$", "rad/s^2", "rad s⁻²", 1.0,
       "dry friction of the Hertz contact per inertia (eq:tf(phi))"),
    _P("phi_max_rad", "φ_max", "$φ_{max}$", "rad", "°", _DEGREES, "largest deflection, at the first sample"),
    _P("psi_start_rad", "ψ_start", "$ψ_{start}$", "rad", "°", _DEGREES, "phase at the first sample, 0 to 2 π"),
    _P("rodrigues_x", "R_x", "$R_x$", "rad", "rad", 1.0, "rotation vector of the rotor's frame (u, v, w), x"),
    _P("rodrigues_y", "R_y", "$R_y$", "rad", "rad", 1.0, "rotation vector of the rotor's frame (u, v, w), y"),
    _P("rodrigues_z", "R_z", "$R_z$", "rad", "rad", 1.0, "rotation vector of the rotor's frame (u, v, w), z"),
    _P("coulomb_rad_per_s2", "a", "$a$", "rad/s^2", "rad s⁻²", 1.0,
       "dry friction of constant size per inertia (eq:Jewel_ODE_norm_simp)"),
    _P("quadratic_drag_per_rad", "b", "$b$", "1/rad", "rad⁻¹", 1.0, "drag of a turbulent flow, -b φ' |φ'|"),
    _P("kappa_per_s", "κ", "κ", "1/s", "s⁻¹", 1.0, "damping that grows with the deflection, -2 κ φ² φ'"),
    _P("anharmonicity", "β", "β", "1", "", 1.0, "restoring torque × [1 - β (1 - cos φ)]"),
    _P("torsion_stiffness", "k", "$k$", "1", "", 1.0, "elastic torque in addition to the magnetic one, -k ω² φ"),
    _P("bias_rad_per_s2", "t", "$t$", "rad/s^2", "rad s⁻²", 1.0, "constant torque per inertia"),
    _P("stribeck_rad_per_s2", "a_s", "$a_s$", "rad/s^2", "rad s⁻²", 1.0,
       "excess of the Hertz contact's friction at rest per inertia"),
    _P("stribeck_speed_rad_per_s", "v_s", "$v_s$", "rad/s", "rad s⁻¹", 1.0, "speed at which that has fallen to 1/e"),
    _P("stribeck_coulomb_rad_per_s2", "a_c", "$a_c$", "rad/s^2", "rad s⁻²", 1.0,
       "excess of a dry friction at rest per inertia, -sgn(φ') a_c exp(-|φ'|/v_c)"),
    _P("stribeck_coulomb_speed_rad_per_s", "v_c", "$v_c$", "rad/s", "rad s⁻¹", 1.0,
       "speed at which that has fallen to 1/e"),
    _P("cubic_restoring", "k_3", "$k_3$", "1", "", 1.0, "further restoring torque -k_3 ω² φ³"),
    _P("frequency_drift_per_s", "d", "$d$", "1/s", "s⁻¹", 1.0, "relative change of f_nat per second"),
    _P("frequency_settling_per_s", "d_0", "$d_0$", "1/s", "s⁻¹", 1.0,
       "relative change of f_nat per second at the first sample, that dies away"),
    _P("frequency_settling_rate_per_s", "r", "$r$", "1/s", "s⁻¹", 1.0, "rate at which that dies away"),
    _P("power_restoring", "k_p", "$k_p$", "1", "", 1.0, "further restoring torque -k_p ω² a (|φ|/a)^p sgn(φ)"),
    _P("power_restoring_exponent", "p", "$p$", "1", "", 1.0, "its power of the deflection"),
    _P("power_restoring_angle_rad", "a", "$a$", "rad", "rad", 1.0, "its deflection at which it is k_p of a spring"),
    _P("dahl_rad_per_s2", "a_d", "$a_d$", "rad/s^2", "rad s⁻²", 1.0,
       "dry friction that builds up after each turn, per inertia"),
    _P("dahl_displacement_rad", "d_s", "$d_s$", "rad", "rad", 1.0, "angle over which it builds up"),
    _P("weight_over_pull", "g", "$g$", "1", "", 1.0,
       "weight of the rotor over the pull of the magnets; friction × (cos φ + g)^(4/3) / cos^(4/3) φ"),
)  # fmt: skip
PARAMETERS: dict[str, ParameterDefinition] = {p.name: p for p in _TABLE}
"""By name, in the order in which results list them."""
RODRIGUES = ("rodrigues_x", "rodrigues_y", "rodrigues_z")
"""The three components of the orientation."""
PAPER_NOISE_AM2_PER_S = (0.014, 0.021, 0.055)
"""Noise of dm/dt per sample on x, y, z, A m^2/s: footnote of the paper's "Primary Results"."""
PAPER_DEFLECTION_DEG = {"thread": 22.8, "jewel": 53.0}
"""Largest deflection by variant, degrees: paper tab:model_params_fit_result, D30."""


def definition_of(name: str) -> ParameterDefinition:
    """Of a parameter; one that the table does not hold is shown by its name, which has its unit."""
    return PARAMETERS.get(name) or ParameterDefinition(name, name, name, "", "", 1.0, "a parameter of another model")


def names_in_order(names: set[str]) -> list[str]:
    """Parameters in the order in which results list them; those of other models, which the table lacks, come last."""
    return [*(name for name in PARAMETERS if name in names), *sorted(names - set(PARAMETERS))]
