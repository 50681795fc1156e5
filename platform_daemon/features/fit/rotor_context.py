"""What a recording says of its rotor and its drive, for fits of a rotor with five degrees of freedom."""

from __future__ import annotations

import math

import numpy as np

from drivers.specimen import Specimen
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.core.settings import load_specimen
from platform_daemon.design.equations import magnetic_moment
from platform_daemon.estimation.physics.rigid_rotor.geometry import RotorGeometry
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.rotor_fit.shot import RotorContext
from platform_daemon.features.fit.known_moment import declared_specimen

BEARINGS = ("thread", "jewel")
"""Those of which a resonator is shipped."""


def rotor_context(recording: Recording, frame: int) -> RotorContext | None:
    """Of one frame; None if the recording declares no resonator, or was not driven by a sine."""
    found = assumed_rotor_context(recording, frame, "")
    return None if found is None or found.assumed else found


def assumed_rotor_context(recording: Recording, frame: int, bearing: str) -> RotorContext | None:
    """The same for recordings that do not tell all of it: with the geometry of the shipped resonator with this bearing
    in the place of an unknown one, and a free start in the place of an unknown drive; None for another bearing."""
    specimen, drive, assumed = declared_specimen(recording), _drive(recording, frame), list[str]()
    rotation = None if specimen is None else rotation_from_rodrigues(np.array(specimen.pose.rodrigues_rad))
    if drive is None:
        assumed.append("no drive by a sine is known, so that each motion begins in any state")
    if specimen is not None:
        geometry = rotor_geometry(specimen)
    elif bearing in BEARINGS:
        geometry = rotor_geometry(load_specimen(bearing)[0]).with_tolerances()
        link = "cup" if bearing == "jewel" else "thread"
        assumed.append(
            f"no resonator is declared: magnets and bearing are taken for those of {bearing}.toml, the magnets' radius "
            f"within {100.0 * geometry.radius_sd_m / geometry.radius_m:g} %, the {link} within "
            f"{100.0 * geometry.link_sd_m / geometry.link_m:g} %"
        )
    else:
        return None
    swinging = recording.frame_info[frame].shot > 1
    return RotorContext(geometry=geometry, drive=drive, rotation=rotation, swinging=swinging, assumed=tuple(assumed))


def _drive(recording: Recording, frame: int) -> CoilDrive | None:
    info, sequence = recording.frame_info[frame], recording.sequence
    drive = info.excitation
    if drive is None or drive.waveform != "sine" or not drive.field_t > 0.0:
        return None
    step = sequence if info.step is None else info.step
    direction = np.asarray(drive.axis, dtype=np.float64) / np.linalg.norm(drive.axis)
    x, y, z = (drive.field_t * direction).tolist()
    return CoilDrive(
        field_t=(x, y, z),
        frequency_hz=drive.realised_hz,
        phase_rad=drive.phase_rad,
        duration_s=step.tx_samples / sequence.rate_hz,
        rx_start_s=(step.tx_samples + step.switch_samples) / sequence.rate_hz,
    )


def rotor_geometry(specimen: Specimen) -> RotorGeometry:
    """By the drawing of a resonator: its magnets and its bearing, not what is measured or wrong about it."""
    magnets = specimen.magnets
    link_m = specimen.thread.length_m if specimen.thread else 0.0
    if specimen.jewel:
        link_m = specimen.jewel.cup_radius_m - magnets.radius_m
    return RotorGeometry(
        bearing=specimen.variant,
        radius_m=magnets.radius_m,
        mass_kg=4 / 3 * math.pi * magnets.radius_m**3 * magnets.density_kg_per_m3,
        stator_moment_am2=magnetic_moment(magnets),
        link_m=link_m,
        friction_coefficient=specimen.jewel.friction_coefficient if specimen.jewel else 0.0,
    )
