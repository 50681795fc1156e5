"""What to expect of a specimen before anything is recorded: its inertia, moment and natural frequency."""

from __future__ import annotations

import math

from drivers.specimen import Specimen

from .equations import magnetic_moment, moment_of_inertia, natural_angular_frequency


def expected_inertia(specimen: Specimen) -> float:
    """Moment of inertia of the rotor, a homogeneous sphere, kg m^2: 8/15 pi rho r^5."""
    return moment_of_inertia(specimen.magnets)


def expected_moment(specimen: Specimen) -> float:
    """Magnetic moment of the rotor, A m^2: measured, else of a homogeneously magnetised sphere (paper eq:m_r)."""
    return specimen.measured.m_r_am2 or magnetic_moment(specimen.magnets)


def expected_omega(specimen: Specimen) -> float:
    """Natural angular frequency, rad/s: measured, else that of two equal spheres (paper eq:fnat)."""
    measured = specimen.measured.f_nat_hz
    return 2 * math.pi * measured if measured else natural_angular_frequency(specimen.magnets)
