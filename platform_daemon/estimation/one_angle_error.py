"""By how much the constants of a jewel's fit are off because one angle stands for a rotor of five degrees of freedom.

A field that is not quite across the main axis kicks the side modes of a jewel's rotor.  While they ring its contact
slips, and a contact that slips brakes the spin less: the losses that one angle finds are off by many times what the
noise makes of them, and the residual shows nothing.  A rotor of five degrees of freedom with the constants that were
found and the drive that was recorded, fitted like the record, tells how far.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .fit import fit_ring_down
from .noise.model import NoiseModel
from .numerics.arrays import Array
from .parameters import RODRIGUES, Estimate
from .physics.models import RingDownModel
from .physics.rigid_rotor.rotor import LostRotorError, NoRestError, RigidRotor, RotorValues
from .physics.rotation import rotation_from_rodrigues
from .record import RingDownRecord
from .result import FitResult
from .rotor_fit.shot import RotorContext
from .thresholds import THRESHOLDS

LIMITS = THRESHOLDS.rigid_rotor
CONSTANTS = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2")


@dataclass(frozen=True, eq=False, kw_only=True)
class Fitted:
    """What was fitted: the model, its first sample (from the first RX sample on) and how many, the rate, Hz, and the
    noise of a sample, (3,) A m^2/s."""

    model: RingDownModel
    first: int
    samples: int
    rate_hz: float
    sd: Array


def one_angle_error(
    fitted: Fitted, values: Mapping[str, float], known: RotorContext, fixed: Mapping[str, float]
) -> dict[str, float]:
    """What the same fit makes of a rotor without manufacturing errors, less the rotor's own: by name of CONSTANTS, SI.

    Args:
        fitted: see there.
        values: of the fit by public name, the orientation among them.
        known: geometry and drive.
        fixed: what the fit held, by public name.

    Empty where the drive is not known, there is no such rotor, or no fit of it.
    """
    if known.drive is None:
        return {}
    n, rate = fitted.samples, fitted.rate_hz
    jewel = known.geometry.bearing == "jewel"
    rotor = RotorValues(
        f_nat_hz=values["f_nat_hz"],
        m_r_am2=values["m_r_am2"],
        lambda_per_s=values.get("lambda_per_s", 0.0),
        tf_over_i_rad_per_s2=values.get("tf_over_i_rad_per_s2", 0.0),
        rotation=known.facing(rotation_from_rodrigues(np.array([values[name] for name in RODRIGUES]))),
        distance_m=known.geometry.distance_m(values["f_nat_hz"], values["m_r_am2"]),
        friction_coefficient=known.geometry.friction_coefficient,
        side_damping_per_s=LIMITS.usual_side_damping_per_s,
        lean_damping_per_s=LIMITS.usual_side_damping_per_s,
        creep_m_per_s=LIMITS.usual_creep_m_per_s if jewel else 0.0,
    )
    drive = known.drive_from(fitted.first / rate)
    try:
        samples, _ = RigidRotor(known.geometry, rotor, drive).dm_dt(n, rate)
    except (NoRestError, LostRotorError):
        return {}
    record = RingDownRecord(samples, rate, "dmdt")
    again = fit_ring_down(record, fitted.model, n / rate, noise=NoiseModel.white(fitted.sd, rate), fixed=dict(fixed))
    return {
        name: again.parameters[name].value - values[name]
        for name in CONSTANTS
        if name in again.parameters and name in values
    }


def with_one_angle_error(
    fit: FitResult, record: RingDownRecord, noise: NoiseModel | None, model: RingDownModel, known: RotorContext
) -> FitResult:
    """A good fit of dm/dt whose errors, and their correlations, contain it; others as they are."""
    if fit.verdict != "good" or noise is None or record.quantity != "dmdt" or fit.samples is None:
        return fit
    held = {c.name for c in model.coefficients}
    fixed = {name: e.value for name, e in fit.parameters.items() if e.std is None and name in held}
    fitted = Fitted(
        model=model, first=record.valid_from, samples=fit.samples, rate_hz=record.sampling_rate_hz, sd=noise.sd
    )
    off = one_angle_error(fitted, {name: e.value for name, e in fit.parameters.items()}, known, fixed)
    if not off:
        return fit
    along = np.array([off.get(name, 0.0) for name in fit.covariance_names])
    covariance = fit.covariance + np.outer(along, along)
    std = dict(zip(fit.covariance_names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    return replace(
        fit,
        covariance=covariance,
        parameters={name: Estimate(e.value, std.get(name, e.std)) for name, e in fit.parameters.items()},
        notes=(*fit.notes, *said_of(off, {name: e.std for name, e in fit.parameters.items()})),
    )


def said_of(off: Mapping[str, float], std: Mapping[str, float | None]) -> tuple[str, ...]:
    """The note of a fit, in a tuple: which constants are off by more than their standard deviation; (): none is.

    off: as one_angle_error returns it; std: by public name, SI, of the noise alone; None: held.
    """
    large = [f"{n} by {value:.2g}" for n, value in off.items() if (noise := std.get(n)) and abs(value) > noise]
    if not large:
        return ()
    return (
        f"one angle stands for a rotor whose side modes the drive kicks, and may be off in {', '.join(large)}: the "
        "errors contain it",
    )
