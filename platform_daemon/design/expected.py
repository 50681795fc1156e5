"""What to expect of a specimen before anything is recorded: its inertia, moment and natural frequency."""

from __future__ import annotations

import math

from drivers.specimen import Specimen

VACUUM_PERMEABILITY = 1.25663706127e-6  # T m/A (CODATA 2022)


def expected_inertia(specimen: Specimen) -> float:
    """Moment of inertia of the rotor, a homogeneous sphere, kg m^2: 8/15 pi rho r^5."""
    m = specimen.magnets
    return 8 / 15 * math.pi * m.density_kg_per_m3 * m.radius_m**5


def expected_moment(specimen: Specimen) -> float:
    """Magnetic moment of the rotor, A m^2: measured, else of a homogeneously magnetised sphere (paper eq:m_r)."""
    m = specimen.magnets
    design = 4 / 3 * math.pi * m.radius_m**3 * m.remanence_t / VACUUM_PERMEABILITY
    return specimen.measured.m_r_am2 or design


def expected_omega(specimen: Specimen) -> float:
    """Natural angular frequency, rad/s: measured, else that of two equal spheres (paper eq:fnat)."""
    m = specimen.magnets
    square = 5 * m.remanence_t**2 * m.radius_m / (6 * m.density_kg_per_m3 * m.distance_m**3 * VACUUM_PERMEABILITY)
    measured = specimen.measured.f_nat_hz
    return 2 * math.pi * measured if measured else math.sqrt(square)
