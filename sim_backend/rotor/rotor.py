"""The resonator from its physical parameters: two magnetised spheres, a bearing, and measured values."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivers.errors import ConfigError
from drivers.specimen import Defects, JewelBearing, Magnets, Specimen

MU_0 = 1.25663706127e-06
"""Vacuum magnetic permeability, V s/(A m), CODATA 2022; `scipy.constants` takes longer to load than a plan to make."""

FLUCTUATION_WAVES = 64
"""Waves that make up what fluctuates within a shot."""

UNDECLARED_DAMPING_PER_S = {"thread": 0.2465, "jewel": 0.0978}
"""Viscous damping of a resonator whose file declares none, 1/s: the paper's (tab:model_params_fit_result)."""


@dataclass(frozen=True, kw_only=True)
class RotorDesign:
    """Design values of the two spheres and the bearing, by the paper's equations.

    m_r_am2: moment of the rotor (eq:m_r); m_stator_am2: of the stator, an equal sphere; b_0_t: field of the stator at
    the rotor; inertia_kg_m2: homogeneous sphere; f_nat_hz: eq:fnat; axial_force_n: eq:fm(phi) at phi = 0;
    tf_nm, tf_over_i_rad_per_s2: eq:tf(phi) at phi = 0, both 0 without a jewel.
    """

    m_r_am2: float
    m_stator_am2: float
    b_0_t: float
    inertia_kg_m2: float
    f_nat_hz: float
    axial_force_n: float
    tf_nm: float
    tf_over_i_rad_per_s2: float


@dataclass(frozen=True, kw_only=True)
class BodyDesign:
    """Additional parameters of a rotor with five degrees of freedom: geometry, defects, damping of the side modes.

    distance_m: of the centres, such that the stator's design moment and the measured m_r give the measured f_nat;
    hertz_m_per_n13: contact radius over the cube root of the force (eq:a), 0 without a jewel; gravity_m_per_s2: in
    world axes, (3,) float64.
    """

    radius_m: float
    mass_kg: float
    distance_m: float
    thread_length_m: float
    cup_radius_m: float
    hertz_m_per_n13: float
    side_damping_per_s: float
    gravity_m_per_s2: NDArray[np.float64]
    defects: Defects


@dataclass(frozen=True, kw_only=True)
class Rotor:
    """The present state of the resonator, which determines the coefficients of eq:Thread_ODE_norm and
    eq:Jewel_ODE_norm.

    inertia_kg_m2 is always the design value; b_0_t is the field that makes m_r B_0 / I = omega_nat^2 (eq:omega_nat)
    with the effective moment; rotation: (3, 3) float64, maps u, v, w to world x, y, z; position_m: (3,) float64; body:
    parameters of the rigid body, None: one degree of freedom; contact: effective radius of a jewel's contact in this
    shot, relative to that of eq:a; friction_waves: angular frequency, rad/s, and phase at the trigger, rad, of the
    waves that friction fluctuates by in this shot, (FLUCTUATION_WAVES, 2), None: it does not; frequency_waves: the
    same of f_nat.
    """

    variant: str
    inertia_kg_m2: float
    f_nat_hz: float
    m_r_am2: float
    lambda_per_s: float
    tf_over_i_rad_per_s2: float
    rotation: NDArray[np.float64]
    position_m: NDArray[np.float64]
    body: BodyDesign | None = None
    contact: float = 1.0
    friction_waves: NDArray[np.float64] | None = None
    frequency_waves: NDArray[np.float64] | None = None

    @property
    def omega_rad_per_s(self) -> float:
        """Natural angular frequency (eq:omega_nat)."""
        return 2 * np.pi * self.f_nat_hz

    def later(self, seconds: float) -> Rotor:
        """The rotor with the waves of its friction and f_nat on a time axis that begins later."""
        if self.friction_waves is None and self.frequency_waves is None:
            return self
        return replace(
            self,
            friction_waves=None if self.friction_waves is None else later_waves(self.friction_waves, seconds),
            frequency_waves=None if self.frequency_waves is None else later_waves(self.frequency_waves, seconds),
        )

    @property
    def axes(self) -> NDArray[np.float64]:
        """Axes along which the moment changes, as columns: e_u, e_v (3, 2), for a rigid body also e_w (3, 3)."""
        return self.rotation if self.body else self.rotation[:, :2]

    @property
    def b_0_t(self) -> float:
        """Stator field at the rotor that follows from f_nat and m_r, T."""
        return self.inertia_kg_m2 * self.omega_rad_per_s**2 / self.m_r_am2


def later_waves(waves: NDArray[np.float64], seconds: float) -> NDArray[np.float64]:
    """Waves (n, 2), angular frequency and phase, on a time axis that begins later."""
    omega, phase = waves.T
    return np.column_stack([omega, phase + omega * seconds])


def sphere_moment_am2(magnets: Magnets) -> float:
    """Moment of one homogeneously magnetised sphere, A m^2 (eq:m_r)."""
    return 4 * np.pi * magnets.radius_m**3 * magnets.remanence_t / (3 * MU_0)


def sphere_inertia_kg_m2(magnets: Magnets) -> float:
    """Moment of inertia of a homogeneous sphere about a diameter, kg m^2."""
    mass_kg = magnets.density_kg_per_m3 * 4 / 3 * np.pi * magnets.radius_m**3
    return 0.4 * mass_kg * magnets.radius_m**2


def axial_force_n(magnets: Magnets) -> float:
    """Attraction of the two spheres at phi = 0, N (eq:fm(phi))."""
    return 4 * np.pi * magnets.remanence_t**2 / (3 * MU_0) * magnets.radius_m**6 / magnets.distance_m**4


def contact_radius_m(magnets: Magnets, jewel: JewelBearing, force_n: float) -> float:
    """Radius of the Hertzian pressure circle, m (eq:a)."""
    e_1, e_2 = jewel.youngs_modulus_jewel_pa, jewel.youngs_modulus_coating_pa
    compliance = (1 - jewel.poissons_ratio**2) * (e_1 + e_2) / (e_1 * e_2)
    curvature_m = magnets.radius_m * jewel.cup_radius_m / (jewel.cup_radius_m - magnets.radius_m)
    return float(np.cbrt(0.75 * compliance * curvature_m * force_n))


def friction_torque_nm(magnets: Magnets, jewel: JewelBearing) -> float:
    """Dry friction torque of the jewel contact at phi = 0, N m (eq:tf)."""
    force_n = axial_force_n(magnets)
    return 3 / 16 * np.pi * contact_radius_m(magnets, jewel, force_n) * jewel.friction_coefficient * force_n


def design(specimen: Specimen) -> RotorDesign:
    """Design values of a specimen.  Raises ConfigError if the jewel's cup is not wider than the sphere."""
    _check(specimen)
    magnets = specimen.magnets
    moment, inertia = sphere_moment_am2(magnets), sphere_inertia_kg_m2(magnets)
    b_0 = MU_0 * moment / (4 * np.pi * magnets.distance_m**3)
    tf = friction_torque_nm(magnets, specimen.jewel) if specimen.jewel else 0.0
    return RotorDesign(
        m_r_am2=moment,
        m_stator_am2=moment,
        b_0_t=b_0,
        inertia_kg_m2=inertia,
        f_nat_hz=float(np.sqrt(moment * b_0 / inertia) / (2 * np.pi)),
        axial_force_n=axial_force_n(magnets),
        tf_nm=tf,
        tf_over_i_rad_per_s2=tf / inertia,
    )


def effective(specimen: Specimen) -> Rotor:
    """The rotor of a specimen: measured values where the specimen has them, else design values.  Raises as `design`."""
    plan, measured = design(specimen), specimen.measured
    rotor = Rotor(
        variant=specimen.variant,
        inertia_kg_m2=plan.inertia_kg_m2,
        f_nat_hz=_first(measured.f_nat_hz, plan.f_nat_hz),
        m_r_am2=_first(measured.m_r_am2, plan.m_r_am2),
        lambda_per_s=_first(measured.lambda_per_s, UNDECLARED_DAMPING_PER_S[specimen.variant]),
        tf_over_i_rad_per_s2=_first(measured.tf_over_i_rad_per_s2, plan.tf_over_i_rad_per_s2),
        rotation=rotation_matrix(np.array(specimen.pose.rodrigues_rad)),
        position_m=np.array(specimen.pose.position_m),
    )
    return replace(rotor, body=_body(specimen, plan, rotor)) if specimen.rotor.model == "rigid_body" else rotor


def _body(specimen: Specimen, plan: RotorDesign, rotor: Rotor) -> BodyDesign:
    magnets, jewel = specimen.magnets, specimen.jewel
    return BodyDesign(
        radius_m=magnets.radius_m,
        mass_kg=2.5 * plan.inertia_kg_m2 / magnets.radius_m**2,
        distance_m=float(np.cbrt(MU_0 * plan.m_stator_am2 / (4 * np.pi * rotor.b_0_t))),
        thread_length_m=specimen.thread.length_m if specimen.thread else 0.0,
        cup_radius_m=jewel.cup_radius_m if jewel else 0.0,
        hertz_m_per_n13=contact_radius_m(magnets, jewel, 1.0) if jewel else 0.0,
        side_damping_per_s=specimen.rotor.side_damping_per_s,
        gravity_m_per_s2=np.array(specimen.rotor.gravity_m_per_s2),
        defects=specimen.defects or Defects(),
    )


def rotation_matrix(rodrigues_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 3) float64 rotation of a (3,) Rodrigues vector in rad (paper, "Analysis of Measurement Data")."""
    theta = float(np.linalg.norm(rodrigues_rad))
    if theta == 0.0:
        return np.eye(3)
    x, y, z = rodrigues_rad / theta
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    axis = np.array([x, y, z])
    return np.cos(theta) * np.eye(3) + (1 - np.cos(theta)) * np.outer(axis, axis) + np.sin(theta) * cross


def _first(measured: float | None, designed: float) -> float:
    return designed if measured is None else measured


def _check(specimen: Specimen) -> None:
    jewel, magnets = specimen.jewel, specimen.magnets
    if jewel is not None and jewel.cup_radius_m <= magnets.radius_m:
        raise ConfigError(
            f"a cup of {jewel.cup_radius_m} m is not wider than the sphere of {magnets.radius_m} m",
            where=f"resonator {specimen.name!r}, jewel.cup_radius_m",
            why="eq:a holds for R > r",
        )
