"""Design equations of a resonator and statics of its manufacturing defects: what magnets, masses and distances say.

Pure; numpy and math only.  The equations are those of "Impact of Structural Design on Magneto-Mechanical Resonators",
cited by the labels of its LaTeX source.  Side modes will stand beside them.  The simulated world has implementations of
its own, and a test holds the two against each other.

PAPER_JEWEL: The cup of the paper's section "Materials and sizing", R = 5/3 r, with the constants of its footnote.
PAPER_MAGNETS: The magnets of that section.
PAPER_THREAD: The thread of that section, l = 8 r.
PRINTED_FRICTION_RAD_PER_S2: T_f/I as printed there.
PRINTED_FRICTION_TORQUE_NM: T_f as printed there; it does not follow from the printed mu.
DesignNumbers: m_r, I, B_0, f_nat, F_m, F_g, and the friction of a jewel bearing.
design_numbers: All of it, from magnets and bearing alone.
friction_coefficient_of: The mu with which the equations give a T_f.
expected_inertia: Moment of inertia of the rotor, a homogeneous sphere, kg m^2.
expected_moment: Magnetic moment of the rotor, A m^2; measured, else by design.
expected_omega: Natural angular frequency at small angles, rad/s; measured, else by design.
Bearing: thread or jewel.
DefectKind: A manufacturing defect without its size.
StaticResonator: What the static analysis takes of a resonator.
NoEquilibrium: The rotor comes to rest nowhere.
StaticAnalysis: A defect of n sizes, each at k deflections.
static_analysis: Position of rest, new axis and equivalent perpendicular force.
"""

from .equations import (
    PAPER_JEWEL,
    PAPER_MAGNETS,
    PAPER_THREAD,
    PRINTED_FRICTION_RAD_PER_S2,
    PRINTED_FRICTION_TORQUE_NM,
    DesignNumbers,
    design_numbers,
    friction_coefficient_of,
)
from .expected import expected_inertia, expected_moment, expected_omega
from .geometry import Bearing, DefectKind, StaticResonator
from .perpendicular_force import NoEquilibrium, StaticAnalysis, static_analysis

__all__ = [
    "PAPER_JEWEL",
    "PAPER_MAGNETS",
    "PAPER_THREAD",
    "PRINTED_FRICTION_RAD_PER_S2",
    "PRINTED_FRICTION_TORQUE_NM",
    "Bearing",
    "DefectKind",
    "DesignNumbers",
    "NoEquilibrium",
    "StaticAnalysis",
    "StaticResonator",
    "design_numbers",
    "expected_inertia",
    "expected_moment",
    "expected_omega",
    "friction_coefficient_of",
    "static_analysis",
]
