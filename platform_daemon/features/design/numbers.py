"""Numbers of a design, and the paper's procedure in six steps."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drivers.errors import InputError
from drivers.specimen import JewelBearing, Magnets, Specimen
from platform_daemon.design.equations import (
    PAPER_JEWEL,
    PAPER_MAGNETS,
    PRINTED_FRICTION_RAD_PER_S2,
    PRINTED_FRICTION_TORQUE_NM,
    DesignNumbers,
    design_numbers,
    friction_coefficient_of,
)
from platform_daemon.design.geometry import Bearing, DefectKind
from platform_daemon.design.perpendicular_force import NoEquilibrium, StaticAnalysis, static_analysis

from .checked_defect import own_span_over_r, static_resonator
from .defects import ratio
from .schema import (
    DesignReport,
    FrictionReport,
    MagnetValues,
    MeasuredValues,
    PrintedFriction,
    ProcedureStep,
    StaticProcedure,
)

EPS_DEG, PHI_DEG = 2.0, 30.0  # at which the six steps are shown
ROUNDING = 1e-12
SECTION = "ssec:manufacturing_errors_side_modes"


def numbers_of(specimen: Specimen | None) -> DesignNumbers:
    """Of a specimen by its design, or of the paper's jewel.  Raises InputError if there is no such resonator."""
    magnets, jewel = (PAPER_MAGNETS, PAPER_JEWEL) if specimen is None else (specimen.magnets, specimen.jewel)
    why = "magnets of this size have no numbers that a computer can hold"
    try:
        found = design_numbers(magnets, jewel)
        if all(0 < x < math.inf for x in (found.m_r_am2, found.inertia_kg_m2, found.b_0_t, found.f_nat_hz)):
            return found
    except ValueError as error:
        why = str(error)
    except ArithmeticError:
        pass
    where, remedy = "" if specimen is None else specimen.name, "correct the magnets and the cup of the resonator"
    raise InputError("its design makes no sense", where=where, why=why, remedy=remedy)


def design_report(specimen: Specimen | None = None) -> DesignReport:
    """Of a specimen, or of the paper's design point with both bearings.  Raises InputError."""
    magnets, jewel = (PAPER_MAGNETS, PAPER_JEWEL) if specimen is None else (specimen.magnets, specimen.jewel)
    numbers = numbers_of(specimen)
    bearings: Sequence[Bearing] = ("jewel", "thread") if specimen is None else (specimen.variant,)
    measured = None
    if specimen is not None:
        m = specimen.measured
        measured = MeasuredValues(m_r_am2=m.m_r_am2, f_nat_hz=m.f_nat_hz, tf_over_i_rad_per_s2=m.tf_over_i_rad_per_s2)
    return DesignReport(
        resonator="the paper's design point" if specimen is None else specimen.name,
        magnets=MagnetValues(**magnets.model_dump()),
        m_r_am2=numbers.m_r_am2,
        inertia_kg_m2=numbers.inertia_kg_m2,
        b_0_t=numbers.b_0_t,
        f_nat_hz=numbers.f_nat_hz,
        f_m_n=numbers.f_m_n,
        f_g_n=numbers.f_g_n,
        friction=None if jewel is None else _friction(numbers, magnets, jewel),
        measured=measured,
        procedures=tuple(_procedure(b, specimen, numbers.f_g_n) for b in bearings),
    )


def _friction(numbers: DesignNumbers, magnets: Magnets, jewel: JewelBearing) -> FrictionReport:
    friction = numbers.friction
    assert friction is not None
    return FrictionReport(
        cup_radius_over_r=jewel.cup_radius_m / magnets.radius_m,
        friction_coefficient=friction.friction_coefficient,
        lambda_factor=friction.friction_increase,
        contact_radius_m=friction.contact_radius_m,
        t_f_nm=friction.friction_torque_nm,
        tf_over_i_rad_per_s2=friction.friction_rad_per_s2,
        quality_factor_per_rad=friction.quality_factor_per_rad,
        printed=_printed(magnets, jewel) if (magnets, jewel) == (PAPER_MAGNETS, PAPER_JEWEL) else None,
    )


def _printed(magnets: Magnets, jewel: JewelBearing) -> PrintedFriction:
    follows = friction_coefficient_of(PRINTED_FRICTION_TORQUE_NM, magnets, jewel)
    return PrintedFriction(
        friction_coefficient=jewel.friction_coefficient,
        t_f_nm=PRINTED_FRICTION_TORQUE_NM,
        tf_over_i_rad_per_s2=PRINTED_FRICTION_RAD_PER_S2,
        follows_from_friction_coefficient=follows,
        note=f"the paper prints T_f = {PRINTED_FRICTION_TORQUE_NM * 1e9:.1f} nNm and T_f/I = "
        f"{PRINTED_FRICTION_RAD_PER_S2:.0f} rad/s2; its equations give them with mu = {follows:.2f}, not with the "
        f"printed mu = {jewel.friction_coefficient:.2f}",
    )


def _procedure(bearing: Bearing, specimen: Specimen | None, weight_n: float) -> StaticProcedure:
    """A tilted stator, step by step.  Raises InputError."""
    try:
        resonator = static_resonator(bearing, specimen)
        kind = DefectKind(bearing, "stator_tilt")
        found = static_analysis(resonator, kind, [math.radians(EPS_DEG)], [math.radians(PHI_DEG)])
    except NoEquilibrium as refused:
        where = "" if specimen is None else specimen.name
        what = f"the rotor has no position of rest with a stator that is tilted by {EPS_DEG:g} deg"
        raise InputError(what, where=where, why=refused.reason, remedy="correct magnets and bearing") from None
    return StaticProcedure(
        bearing=bearing,
        defect="stator_tilt",
        span_over_r=ratio(own_span_over_r(bearing, specimen)),
        eps_deg=EPS_DEG,
        phi_deg=PHI_DEG,
        f_perp_n=float(found.perpendicular_force_n[0, 0]),
        steps=_steps(found, weight_n),
    )


def _steps(found: StaticAnalysis, weight_n: float) -> tuple[ProcedureStep, ...]:
    eps, phi = math.radians(EPS_DEG), math.radians(PHI_DEG)
    axis, force, torque = found.axis[0], found.force_n[0, 0], found.torque_nm[0, 0]
    across, tilting = force - (force @ axis) * axis, torque - (torque @ axis) * axis
    what: list[tuple[str, str, dict[str, object]]] = [
        (
            "tilt the stator's dipole by the error angle about x",
            "fig:math_description_angle_defects",
            {"eps_rad": eps, "stator_direction": (0.0, math.cos(eps), math.sin(eps))},
        ),
        (
            "find the rotor's position of rest in its bearing",
            SECTION,
            {
                "centre_m": found.centre_m[0],
                "moment_direction": found.moment[0],
                "dy_c_m": float(found.displacement_m[0]),
            },
        ),
        (
            "take the axis through anchor A and centre C",
            "fig:math_description_angle_defects",
            {"axis": axis, "alpha_rad": float(found.alpha_rad[0]), "reference_point_m": found.reference_point_m[0]},
        ),
        ("deflect the rotor about the new axis", "eq:m_uvw(phi)", {"phi_rad": phi}),
        (
            "take force and torque on the rotor, and their parts across the axis",
            "eq:T_m",
            {
                "force_n": force,
                "torque_nm": torque,
                "force_across_n": float(np.linalg.norm(across)),
                "torque_across_nm": float(np.linalg.norm(tilting)),
            },
        ),
        (
            "reduce them to D on the rotor's surface: F_perp = |M_D,perp| / r",
            SECTION,
            {"f_perp_n": float(found.perpendicular_force_n[0, 0]), "f_g_n": weight_n},
        ),
    ]
    return tuple(
        ProcedureStep(step=k, what=text, source=source, values={n: _plain(v) for n, v in values.items()})
        for k, (text, source, values) in enumerate(what, 1)
    )


def _plain(value: object) -> float | tuple[float, ...]:
    """Numbers as JSON holds them; a component that is nothing but rounding is 0."""
    if isinstance(value, float):
        return value
    vector = np.asarray(value, float)
    return tuple(np.where(np.abs(vector) > ROUNDING * np.abs(vector).max(), vector, 0.0).tolist())
