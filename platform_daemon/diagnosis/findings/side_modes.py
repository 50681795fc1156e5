"""What one angle leaves out of a jewel's rotor, in the errors of what was fitted."""

from __future__ import annotations

import math
from dataclasses import replace

from platform_daemon.diagnosis.regression.parameters import Mean
from platform_daemon.diagnosis.regression.prediction import window_of
from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.estimation.one_angle_error import Fitted, one_angle_error, said_of
from platform_daemon.estimation.physics.models import RingDownModel


def with_side_modes(
    found: dict[str, Mean], prepared: PreparedShot, model: RingDownModel
) -> tuple[dict[str, Mean], tuple[str, ...]]:
    """Parameters whose errors contain what one angle leaves out of a jewel's rotor with a weight, and a note on it."""
    known, held = prepared.shot.rotor, {p.name: p.fixed for p in model.parameters.values() if p.fixed is not None}
    if known is None or "weight_over_pull" not in held:
        return found, ()
    first, last = window_of(prepared)
    shot = prepared.shot
    fitted = Fitted(model=model, first=first, samples=last - first, rate_hz=shot.rate_hz, sd=shot.noise.sd)
    off = one_angle_error(fitted, {name: m.value for name, m in found.items()}, known, held)
    wider = {name: replace(m, std=math.hypot(m.std, off.get(name, 0.0))) for name, m in found.items()}
    return wider, said_of(off, {name: m.std for name, m in found.items()})
