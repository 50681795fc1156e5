"""Fits of windows of a shot, and what these tell too little of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.rotor_fit.fit import RotorFit, RotorFitError, fit_rotor
from platform_daemon.estimation.rotor_fit.parameters import OFF_DRAWING
from platform_daemon.estimation.rotor_fit.shot import RotorShot

from .starts import Start

_LIMITS = THRESHOLDS.rigid_body


def held_in(shot: RotorShot, window_s: float) -> tuple[str, ...]:
    """What a window tells too little of, how far the rotor is off its drawing among it.

    One angle tells a jewel's m_r, and with it the distance, to a thousandth, a thread's only to a tenth; free in a
    short window of a jewel the distance runs away.  In the shortest windows so do, for a thread, the damping of
    its centre and the axis of lambda, and for a jewel all losses, which go with its creep.
    """
    first = window_s <= _LIMITS.sign_window_s
    if shot.geometry.bearing == "thread":
        return ("side_damping_per_s", "damping_axis_to_thread", *OFF_DRAWING) if first else ()
    if first:
        losses = ("lambda_per_s", "side_damping_per_s", "lean_damping_per_s", "creep_m_per_s", "creep_spin_rad_per_s")
        return ("distance_m", *OFF_DRAWING, *losses)
    return ("distance_m", *OFF_DRAWING) if window_s <= _LIMITS.jewel_distance_from_s else ()


def fit_of_window(
    shot: RotorShot,
    window_s: float,
    held: Sequence[str],
    start: Start,
    *,
    whole: bool,
    pool: Executor,
    to_beat: float = math.inf,
) -> RotorFit | None:
    """A fit of a window; None: it finds no rotor, or none that comes below `to_beat`."""
    part = replace(shot, samples=shot.samples[:, : shot.count(window_s)], values=start.values)
    try:
        return fit_rotor(
            [part], start.defect, pool, first_window_s=math.inf, held=held, whole=whole, known=[start.known],
            to_beat=to_beat,
        )  # fmt: skip
    except RotorFitError:
        return None
