"""The estimation's rigid rotor of a specimen, for tests that know the truth."""

from __future__ import annotations

import math
from typing import Any

from drivers.specimen import Specimen
from platform_daemon.design.equations import magnetic_moment
from platform_daemon.estimation.physics.rigid_rotor.geometry import RotorGeometry
from platform_daemon.estimation.physics.rigid_rotor.rotor import NO_DRIVE, CoilDrive, RigidRotor, RotorValues
from sim_backend.rotor.rigid_body.acceleration import MU
from sim_backend.rotor.rigid_body.parameters import REST_SLIP_M_PER_S, REST_SPIN_RAD_PER_S, body_parameters
from sim_backend.rotor.rotor import effective


def geometry(specimen: Specimen) -> RotorGeometry:
    """By the specimen's drawing."""
    magnets, jewel, thread = specimen.magnets, specimen.jewel, specimen.thread
    return RotorGeometry(
        bearing=specimen.variant,
        radius_m=magnets.radius_m,
        mass_kg=4 / 3 * math.pi * magnets.radius_m**3 * magnets.density_kg_per_m3,
        stator_moment_am2=magnetic_moment(magnets),
        link_m=thread.length_m if thread else (jewel.cup_radius_m if jewel else 0.0) - magnets.radius_m,
        friction_coefficient=jewel.friction_coefficient if jewel else 0.0,
    )


def true_rotor(specimen: Specimen, drive: CoilDrive = NO_DRIVE, **other: Any) -> RigidRotor:
    """With the values of the specimen; other: values in the place of them."""
    rotor, defects = effective(specimen), specimen.defects
    assert rotor.body is not None
    values: dict[str, Any] = {
        "f_nat_hz": rotor.f_nat_hz,
        "m_r_am2": rotor.m_r_am2,
        "distance_m": rotor.body.distance_m,
        "lambda_per_s": rotor.lambda_per_s,
        "rotation": rotor.rotation,
        "tf_over_i_rad_per_s2": rotor.tf_over_i_rad_per_s2,
        "friction_coefficient": float(body_parameters(rotor)[MU]),
        "side_damping_per_s": specimen.rotor.side_damping_per_s,
        "lean_damping_per_s": specimen.rotor.side_damping_per_s,
        "creep_m_per_s": REST_SLIP_M_PER_S,
        "creep_spin_rad_per_s": REST_SPIN_RAD_PER_S,
    }
    if defects:
        values |= {
            "stator_tilt_rad": defects.stator_tilt_rad,
            "bearing_tilt_rad": defects.rotor_tilt_rad + defects.jewel_tilt_rad,
            "lateral_displacement_m": defects.stator_offset_m[0],
        }
    return RigidRotor(geometry(specimen), RotorValues(**(values | other)), drive, specimen.rotor.gravity_m_per_s2)
