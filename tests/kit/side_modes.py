"""The threshold of side modes as the simulated world itself knows it: shots at rising field, and their truth."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from drivers.specimen import Specimen
from tests.kit.simulated_bench import CLOCK, QUIET, Bench, specimen

RX_S = {"thread": 2.0, "jewel": 1.0}


def changed(
    name: str, tilt_deg: float | None = None, side_damping: float | None = None, friction: float | None = None
) -> Specimen:
    """A shipped specimen with another stator tilt, side damping 1/s or T_f/I rad/s^2, and always the same way up."""
    tables: dict[str, Any] = specimen(name).model_dump(exclude_none=True)
    tables["rotor"]["orientation_scatter_rad"] = 0.0
    if tilt_deg is not None:
        tables["defects"] = {**tables.get("defects", {}), "stator_tilt_rad": float(np.radians(tilt_deg))}
    if side_damping is not None:
        tables["rotor"]["side_damping_per_s"] = side_damping
    if friction is not None:
        tables["measured"]["tf_over_i_rad_per_s2"] = friction
    return Specimen.model_validate(tables)


def truths(
    mounted: Specimen, fields_ut: Iterable[int], rx_s: float | None = None
) -> Iterator[tuple[int, dict[str, Any]]]:
    """The truth of one shot at each field, each from rest, without noise and without scatter from shot to shot."""
    bench = Bench(None, **QUIET)
    bench.backend.mount(mounted)
    samples = int((rx_s or RX_S[mounted.variant]) * CLOCK.rate_hz)
    for field_ut in fields_ut:
        bench.backend.world.hold_still()
        bench.shot(field_ut * 1e-6, rx=samples)
        yield field_ut, bench.truth()


def threshold_ut(mounted: Specimen, fields_ut: Iterable[int]) -> int | None:
    """The first of these fields at which side modes are visible, uT; None: at none."""
    return next((field_ut for field_ut, truth in truths(mounted, fields_ut) if truth["side_modes_visible"]), None)
