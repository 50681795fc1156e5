"""Design equations of a resonator from its magnets and its bearing.  All quantities are in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drivers.specimen import JewelBearing, Magnets, Specimen, ThreadBearing

VACUUM_PERMEABILITY = 1.25663706127e-6  # T m/A (CODATA 2022)
GRAVITY = 9.81  # m/s^2; the paper's F_g of 1.08 mN is compatible with it and with the standard 9.80665
PAPER_MAGNETS = Magnets(radius_m=1.5e-3, remanence_t=1.3, density_kg_per_m3=7800.0, distance_m=4.7e-3)
"""The magnets of the paper's section "Materials and sizing"."""
PAPER_JEWEL = JewelBearing(
    cup_radius_m=2.5e-3,
    youngs_modulus_jewel_pa=460e9,
    youngs_modulus_coating_pa=279e9,
    poissons_ratio=0.3,
    friction_coefficient=0.15,
)
"""The cup of that section, R = 5/3 r, with the constants of its footnote."""
PAPER_THREAD = ThreadBearing(length_m=12e-3)
"""The thread of that section, l = 8 r."""
PRINTED_FRICTION_TORQUE_NM = 115.9e-9
"""T_f as that section prints it; it does not follow from the printed mu (`friction_coefficient_of`)."""
PRINTED_FRICTION_RAD_PER_S2 = 1168.0
"""T_f/I as printed (paper eq:TfoverI)."""


def magnetic_moment(magnets: Magnets) -> float:
    """m_r of a homogeneously magnetised sphere, A m^2 (paper eq:m_r)."""
    return 4 / 3 * math.pi * magnets.radius_m**3 * magnets.remanence_t / VACUUM_PERMEABILITY


def moment_of_inertia(magnets: Magnets) -> float:
    """I of the rotor, a homogeneous sphere, kg m^2: 8/15 pi rho r^5 (used in paper eq:fnat)."""
    return 8 / 15 * math.pi * magnets.density_kg_per_m3 * magnets.radius_m**5


def stator_field(magnets: Magnets) -> float:
    """B_0, field of the stator's dipole at the rotor, T (paper eq:T_m): B_r r^3 / (3 d^3)."""
    return magnets.remanence_t * (magnets.radius_m / magnets.distance_m) ** 3 / 3


def natural_angular_frequency(magnets: Magnets) -> float:
    """omega_nat of two equal spheres, rad/s (paper eq:fnat)."""
    m = magnets
    square = 5 * m.remanence_t**2 * m.radius_m / (6 * m.density_kg_per_m3 * m.distance_m**3 * VACUUM_PERMEABILITY)
    return math.sqrt(square)


def magnetic_force(magnets: Magnets) -> float:
    """F_m, attraction of the magnets without deflection, N (paper eq:fm(phi))."""
    m = magnets
    return 4 * math.pi * m.remanence_t**2 * m.radius_m**6 / (3 * VACUUM_PERMEABILITY * m.distance_m**4)


def weight(magnets: Magnets) -> float:
    """F_g of the rotor, N."""
    return 4 / 3 * math.pi * magnets.radius_m**3 * magnets.density_kg_per_m3 * GRAVITY


def friction_increase(cup_radius_over_r: float) -> float:
    """Lambda: ratio of the friction in a cup to that on a flat jewel, cube root of k/(k-1) for k = R/r (paper sec.
    ssec:characteristics-of-jewel-bearings).  Raises ValueError unless k > 1; k may be infinite."""
    if not cup_radius_over_r > 1:
        raise ValueError("the cup's radius must be larger than the rotor's")
    return (1 - 1 / cup_radius_over_r) ** (-1 / 3)


def contact_radius(magnets: Magnets, jewel: JewelBearing) -> float:
    """a, radius of the pressure circle under F_m, m (paper eq:a).  Raises ValueError unless R > r."""
    e1, e2 = jewel.youngs_modulus_jewel_pa, jewel.youngs_modulus_coating_pa
    material = (1 - jewel.poissons_ratio**2) * (e1 + e2) / (e1 * e2)
    r = magnets.radius_m
    flat = (3 / 4 * material * r * magnetic_force(magnets)) ** (1 / 3)
    return flat * friction_increase(jewel.cup_radius_m / r)


def friction_torque(magnets: Magnets, jewel: JewelBearing) -> float:
    """T_f without deflection, N m (paper eq:tf, eq:tf(phi)).  Raises ValueError unless R > r."""
    return 3 / 16 * math.pi * contact_radius(magnets, jewel) * jewel.friction_coefficient * magnetic_force(magnets)


def friction_coefficient_of(torque_nm: float, magnets: Magnets, jewel: JewelBearing) -> float:
    """The mu for which the equations give a T_f, N m.  Raises ValueError unless R > r."""
    return torque_nm / (3 / 16 * math.pi * contact_radius(magnets, jewel) * magnetic_force(magnets))


@dataclass(frozen=True, kw_only=True)
class FrictionNumbers:
    """Dry friction of a jewel bearing.

    friction_coefficient: mu; friction_increase: Lambda; contact_radius_m: a, m; friction_torque_nm: T_f, N m;
    friction_rad_per_s2: T_f/I, rad/s^2; quality_factor_per_rad: quality factor at 1 rad, pi m_r B_0 phi_0 / (4 T_f),
    which does not depend on the size (paper sup:proof_size_independence), None without friction.
    """

    friction_coefficient: float
    friction_increase: float
    contact_radius_m: float
    friction_torque_nm: float
    friction_rad_per_s2: float
    quality_factor_per_rad: float | None


@dataclass(frozen=True, kw_only=True)
class DesignNumbers:
    """Design values of a resonator.

    m_r_am2: m_r, A m^2; inertia_kg_m2: I, kg m^2; b_0_t: B_0, T; f_nat_hz: f_nat, Hz; f_m_n, f_g_n: F_m and F_g, N;
    friction: of a jewel bearing, None for a thread.
    """

    m_r_am2: float
    inertia_kg_m2: float
    b_0_t: float
    f_nat_hz: float
    f_m_n: float
    f_g_n: float
    friction: FrictionNumbers | None


def design_numbers(magnets: Magnets, jewel: JewelBearing | None) -> DesignNumbers:
    """All design values; jewel None: a thread bearing.  Raises ValueError unless the rotor fits into the cup."""
    return DesignNumbers(
        m_r_am2=magnetic_moment(magnets),
        inertia_kg_m2=moment_of_inertia(magnets),
        b_0_t=stator_field(magnets),
        f_nat_hz=natural_angular_frequency(magnets) / (2 * math.pi),
        f_m_n=magnetic_force(magnets),
        f_g_n=weight(magnets),
        friction=None if jewel is None else friction_numbers(magnets, jewel),
    )


def friction_numbers(magnets: Magnets, jewel: JewelBearing) -> FrictionNumbers:
    """Dry friction in a cup.  Raises ValueError unless the rotor fits into it."""
    torque = friction_torque(magnets, jewel)
    stiffness = magnetic_moment(magnets) * stator_field(magnets)
    return FrictionNumbers(
        friction_coefficient=jewel.friction_coefficient,
        friction_increase=friction_increase(jewel.cup_radius_m / magnets.radius_m),
        contact_radius_m=contact_radius(magnets, jewel),
        friction_torque_nm=torque,
        friction_rad_per_s2=torque / moment_of_inertia(magnets),
        quality_factor_per_rad=math.pi * stiffness / (4 * torque) if torque > 0 else None,
    )


def expected_inertia(specimen: Specimen) -> float:
    """Moment of inertia of the rotor, a homogeneous sphere, kg m^2: 8/15 pi rho r^5."""
    return moment_of_inertia(specimen.magnets)


def expected_moment(specimen: Specimen) -> float:
    """Magnetic moment of the rotor, A m^2: measured, else of a homogeneously magnetised sphere (paper eq:m_r)."""
    return specimen.measured.m_r_am2 or magnetic_moment(specimen.magnets)


def expected_omega(specimen: Specimen) -> float:
    """Natural angular frequency at small angles, rad/s: measured, else of two equal spheres (paper eq:fnat)."""
    measured = specimen.measured.f_nat_hz
    return 2 * math.pi * measured if measured else natural_angular_frequency(specimen.magnets)
