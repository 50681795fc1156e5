"""Why a shot may show no swing: what the recording knows of its drive, compared with the resonator that it declares."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from drivers.specimen import Specimen
from platform_daemon.core.recordings.recording import Excitation, Recording
from platform_daemon.core.settings import load_sequence
from platform_daemon.design.equations import expected_omega
from platform_daemon.estimation.physics.mirror import rotations
from platform_daemon.estimation.refusal import Refusal
from platform_daemon.estimation.result import FitResult
from platform_daemon.estimation.thresholds.tuned import tuned

from .known_moment import declared_specimen

_WEAK = (Refusal.NO_SIGNAL, Refusal.AMPLITUDE_BELOW_FLOOR)
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, kw_only=True)
class Thresholds:
    """When the drive of a shot counts as the cause of a swing that is not seen."""

    weak_field_share: float = tuned(
        0.05,
        "1",
        "of the preset's field, below which the drive is too weak: the preset's swing of some 55 deg becomes less than "
        "3 deg, of which dry friction takes 1.7 deg within the ten periods of the preset jewel",
    )
    torque_share: float = tuned(
        0.1,
        "1",
        "of the field that is perpendicular to moment and axis of rotation, below which it exerts hardly any torque: "
        "within 6 deg of the parallel, where the swing is a tenth of that of a perpendicular field",
    )


LIMITS = Thresholds()


def with_drive_hint(fit: FitResult, recording: Recording, frame: int) -> FitResult:
    """A fit refused for want of a signal, with the cause that the drive of that frame shows; any other fit as it is.

    Without a cause in the drive, the reason says what the drive was and what is left to check.
    """
    info, sequence = recording.frame_info[frame], recording.sequence
    drive, specimen = info.excitation, declared_specimen(recording) if fit.code in _WEAK else None
    if fit.code is None or fit.reason is None or drive is None or specimen is None or drive.field_t == 0.0:
        return fit
    if not fit.reason.endswith(fit.code.value):  # it has a cause of its own
        return fit
    duration_s = (sequence if info.step is None else info.step).tx_samples / sequence.rate_hz
    causes = _causes(drive, specimen, duration_s)
    seen = fit.reason.removesuffix(f"; {fit.code.value}")
    if causes:
        return replace(fit, reason=f"{seen}; {'; '.join(causes)}")
    return replace(fit, reason=f"{seen}; {_nothing_wrong(drive, specimen, duration_s)}")


def _causes(drive: Excitation, specimen: Specimen, duration_s: float) -> list[str]:
    """What about the drive keeps this resonator from swinging, each with its remedy."""
    causes = []
    preset = load_sequence(specimen.variant)
    if drive.field_t < LIMITS.weak_field_share * preset.field_t:
        causes.append(
            f"the drive was too weak: {_field(drive.field_t)}, {drive.field_t / preset.field_t:.2g} times the "
            f"{_field(preset.field_t)} of the preset {specimen.variant}; raise sequence.field_t (--field-ut)"
        )
    u, v, w = rotations(np.array(specimen.pose.rodrigues_rad)).as_matrix().T
    along = {name: abs(float(drive.axis @ axis)) for name, axis in (("moment", u), ("v", v), ("axis of rotation", w))}
    if along["v"] < LIMITS.torque_share * float(np.linalg.norm(drive.axis)):
        parallel = max("moment", "axis of rotation", key=along.__getitem__)
        causes.append(
            f"the drive exerts hardly any torque: its field along {_direction(drive.axis)} is parallel to the "
            f"{parallel} of the resonator as declared (pose.rodrigues_rad); set sequence.axis (--axis) to "
            f"{_direction(v)}, which is perpendicular to moment and axis of rotation"
        )
    f_nat_hz = expected_omega(specimen) / (2 * math.pi)
    off_hz, reach_hz = drive.realised_hz - f_nat_hz, 1.0 / duration_s
    if drive.waveform == "sine" and abs(off_hz) > reach_hz:
        causes.append(
            f"the drive was off resonance: {drive.realised_hz:.6g} Hz is {abs(off_hz):.3g} Hz "
            f"{'above' if off_hz > 0 else 'below'} the expected f_nat of {f_nat_hz:.6g} Hz, and a drive of "
            f"{1e3 * duration_s:.3g} ms reaches {reach_hz:.2g} Hz to either side; leave f_tx_hz out, or run "
            "`platform-daemon tune`, which finds f_nat"
        )
    return causes


def _nothing_wrong(drive: Excitation, specimen: Specimen, duration_s: float) -> str:
    """What the drive was, where it suits the resonator."""
    f_nat_hz = expected_omega(specimen) / (2 * math.pi)
    return (
        f"the drive suits the declared resonator ({_field(drive.field_t)} along {_direction(drive.axis)}, "
        f"{drive.realised_hz:.6g} Hz for {1e3 * duration_s:.3g} ms, expected f_nat {f_nat_hz:.6g} Hz): check that this "
        "resonator is mounted as declared, that amplifier and switch work (`platform-daemon self-test`), and f_nat "
        "(`platform-daemon tune`)"
    )


def _field(field_t: float) -> str:
    return f"{1e6 * field_t:.4g} uT"


def _direction(vector: np.ndarray) -> str:
    """A direction (3,) in world axes: x, y, z, also with a minus, else its unit vector."""
    unit = np.asarray(vector, dtype=np.float64) / np.linalg.norm(vector)
    for name, axis in _AXES.items():
        if abs(unit @ axis) > 1 - 1e-6:
            return name if unit @ axis > 0 else f"-{name}"
    return "(" + ", ".join(f"{component:.3g}" for component in unit) + ")"
