"""dm/dt of rotors beside each other, in the lanes of one integration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array

from .equations import FIELD, LANES
from .swing import padded, swings

if TYPE_CHECKING:
    from .rotor import RigidRotor

EMPTY: Array = np.zeros(0)


def motions_beside(
    rotors: Sequence[RigidRotor],
    samples: int,
    rate_hz: float,
    steps: Array = EMPTY,
    *,
    near: RigidRotor | None = None,
    counts: Sequence[int] = (),
    late_s: Sequence[float] = (),
) -> tuple[list[Array | None], Array]:
    """dm/dt in world axes, (3, samples) A m^2/s, of up to LANES rotors in the time that one takes.

    Args:
        rotors: of one geometry and drive, but for the size of its field.
        samples: of each.
        rate_hz: of the samples.
        steps: ends of those that the rotor `near` takes, so that their differences are smooth; none: they are chosen,
            for the first one unless there are `counts`.
        counts: of the samples, how many of each rotor are asked for; then steps are chosen that are short enough for
            all of them.
        late_s: by which the first one is sampled later, once more for each of them.
        near: the rotor that chose them, and whose contact decides how they are made; None: the first one.

    Returns:
        Of each, and then of the first one later, None where its motion runs away, and the ends of the steps, s.

    Raises:
        NoRestError: one has no rest.
    """
    one, lanes = rotors[0], padded(rotors)
    out = np.zeros((LANES + len(late_s), samples, 3))
    first_s = np.array([r.drive.rx_start_s + r.values.drive_delay_s for r in lanes])
    until_s = np.zeros(LANES)
    until_s[: len(counts) or 1] = first_s[: len(counts)] + np.array(counts) / rate_hz if counts else np.inf
    ends = swings(
        np.stack(padded([r.start() for r in rotors]), axis=1),
        np.stack([r.parameters for r in lanes], axis=1),
        np.stack([r.coils[FIELD : FIELD + 3] for r in lanes], axis=1),
        one.coils,
        np.append(first_s, first_s[0] + np.array(late_s)),
        1.0 / rate_hz,
        one.tolerances(),
        steps,
        until_s,
        (near or one).sticks,
        out,
    )
    found: list[Array | None] = []
    seen = [*rotors, *[one] * len(late_s)]
    rows = [*range(len(rotors)), *range(LANES, len(out))]
    for rotor, row, count in zip(seen, rows, counts or [samples] * len(seen), strict=True):
        motion = out[row, :count]
        followed = bool(np.all(np.isfinite(motion)))
        found.append(rotor.values.m_r_am2 * (rotor.rotation @ motion.T) if followed else None)
    return found, ends
