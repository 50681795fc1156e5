"""How much the rotor's weight presses it into its cup, as the recording's resonator tells."""

from __future__ import annotations

import numpy as np

from drivers.specimen import Specimen
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.design.equations import expected_moment, expected_omega
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues

from .known_moment import declared_specimen
from .rotor_context import rotor_geometry


def recorded_weight_over_pull(recording: Recording) -> float:
    """Of the resonator whose file the recording carries; 0 without one."""
    specimen = declared_specimen(recording)
    return 0.0 if specimen is None else weight_over_pull(specimen)


def weight_over_pull(specimen: Specimen) -> float:
    """Weight along the main axis, towards the stator, over the pull of the undeflected magnets (eq:fm(phi)).

    0 for a thread, and for a rotor that is declared with one angle, which has no weight.
    """
    if specimen.jewel is None or specimen.rotor.model != "rigid_body":
        return 0.0
    f_nat_hz = expected_omega(specimen) / (2.0 * np.pi)
    geometry = rotor_geometry(specimen)
    main_axis = rotation_from_rodrigues(np.array(specimen.pose.rodrigues_rad))[:, 2]
    weight_n = -geometry.mass_kg * float(main_axis @ np.array(specimen.rotor.gravity_m_per_s2))
    return weight_n / geometry.pull_n(f_nat_hz, geometry.distance_m(f_nat_hz, expected_moment(specimen)))
