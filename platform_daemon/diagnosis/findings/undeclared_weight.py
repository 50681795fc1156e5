"""The weight of a jewel's rotor where no resonator is declared, in the errors of what was fitted.

A rotor presses into its cup by the pull of the magnets and by its own weight, one per cent of it: on the cup where
the stator is below, off it where the stator is above.  A recording without a resonator does not tell which, and noise
hardly shows it: chi^2 of a shot differs by ten, lambda and T_f/I by one per cent, which may be a hundred errors.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.parameters import Mean, clean_record, held_strengths, with_scales
from platform_daemon.diagnosis.regression.prediction import window_of
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.physics.rigid_rotor.geometry import RotorGeometry
from platform_daemon.estimation.physics.rigid_rotor.rotor import DOWN_M_PER_S2
from platform_daemon.estimation.physics.torques.hertz_friction import HERTZ_FRICTION

_FRICTION = "tf_over_i_rad_per_s2"


def weight_of_drawing(geometry: RotorGeometry, found: Mapping[str, Mean]) -> float:
    """Weight over the pull of the magnets (eq:fm(phi)) at the f_nat and m_r that were found.

    0 for a thread, without m_r (an angle), and where a resonator is declared, of which the weight is known.
    """
    if geometry.drawn or geometry.bearing != "jewel" or not {"f_nat_hz", "m_r_am2"} <= found.keys():
        return 0.0
    f_nat_hz = found["f_nat_hz"].value
    pull_n = geometry.pull_n(f_nat_hz, geometry.distance_m(f_nat_hz, found["m_r_am2"].value))
    return geometry.mass_kg * math.hypot(*DOWN_M_PER_S2) / pull_n


def with_undeclared_weight(found: dict[str, Mean], final: JointFit) -> tuple[dict[str, Mean], tuple[str, ...]]:
    """Parameters of one angle whose errors contain what the weight would change, and a note on it.

    The first shot is fitted once more with the weight and once without.
    """
    prepared, model = final.prepared[0], final.hypothesis.augmented
    known = prepared.shot.rotor
    if known is None or HERTZ_FRICTION not in model.terms:
        return found, ()
    share = weight_of_drawing(known.geometry, found)
    if share == 0.0:
        return found, ()
    first, last = window_of(prepared)
    record, fixed = clean_record(final, 0), held_strengths(final, 0)
    fixed |= {final.hypothesis.model.coefficients[k].name: 0.0 for k in final.hypothesis.held_at_zero}
    window_s = (last - first) / record.sampling_rate_hz
    fits = [
        fit_ring_down(record, each, window_s, noise=prepared.shot.noise, fixed=fixed)
        for each in (model, model.under_weight(share))
    ]
    if any(fit.verdict != "good" for fit in fits):
        return with_weight_in_friction(found, known.geometry)
    without, under = (fit.parameters for fit in fits)
    moved = {
        name: replace(m, value=m.value + under[name].value - without[name].value)
        for name, m in found.items()
        if name in under and name in without
    }
    return with_scales(found, [(moved, 1.0)]), (_note(share),)


def with_weight_in_friction(
    found: Mapping[str, Mean], geometry: RotorGeometry
) -> tuple[dict[str, Mean], tuple[str, ...]]:
    """Parameters with an error of T_f/I alone that contains the weight, and a note on it.

    For fits of a rotor, which holds the weight of the drawing: T_f/I is that of the pull alone only if the rotor weighs
    on its cup as the drawing has it.
    """
    share = weight_of_drawing(geometry, found)
    friction = found.get(_FRICTION)
    if share == 0.0 or friction is None:
        return dict(found), ()
    wider = replace(friction, std=math.hypot(friction.std, share * friction.value))
    return {**found, _FRICTION: wider}, (_note(share),)


def _note(share: float) -> str:
    return (
        f"no resonator is declared, and with it no weight of the rotor: {100.0 * share:.2g} % of the pull that presses "
        "it into its cup, or lifts it; the errors contain what one or the other changes"
    )
