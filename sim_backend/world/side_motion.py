"""The truth of the side modes: the moment's true motion, and its part out of the plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim_backend.options import ChainOptions
from sim_backend.receive.chain import receive_v
from sim_backend.receive.shot_setup import ShotSetup

from .shot import ShotResult

VISIBLE_AM2_PER_S = 0.4
"""Largest |z residual| from which side modes count as visible: seven times the z channel's noise in the paper."""
FLAT = ChainOptions(poles_hz=((), (), ()), residual_delay_s=(0.0, 0.0, 0.0))


def true_dm_dt(setup: ShotSetup, result: ShotResult) -> NDArray[np.float64]:
    """dm/dt of the rotor in world axes at the samples of the RX window: (3, n) float64, A m^2/s, without any receiver.

    Zero without a rotor; shorter if the shot was stopped.
    """
    rate, end = setup.timeline.clock.rate_hz, setup.timeline.total_samples
    times = np.arange(setup.timeline.rx_start, end) / rate
    times = times[times < setup.stop_s]
    if setup.rotor is None:
        return np.zeros((3, times.size))
    everywhere = np.ones(len(result.pieces), dtype=np.bool_)
    return receive_v(result.pieces, everywhere, times, setup.rotor.m_r_am2 * setup.rotor.axes, FLAT)


def z_residual(dm_dt: NDArray[np.float64]) -> NDArray[np.float64]:
    """The z component of dm/dt (3, n) without the part that is a linear combination of x and y: (n,) float64.

    A main mode whose axis is not exactly z leaks from x and y into z; side modes are no linear combination of x and y
    (paper, "Measurement Sequence").
    """
    leak, *_ = np.linalg.lstsq(dm_dt[:2].T, dm_dt[2], rcond=None)
    return np.asarray(dm_dt[2] - leak @ dm_dt[:2])


def side_record(setup: ShotSetup, result: ShotResult) -> dict[str, Any]:
    """Truth of main and side modes; with one degree of freedom the main mode is f_nat and there are no side modes."""
    assert setup.rotor is not None
    rotor = setup.rotor
    out: dict[str, Any] = {
        "rotor_model": "single_axis" if rotor.body is None else "rigid_body",
        "main_mode_hz": rotor.f_nat_hz,
        "main_mode_decay_per_s": rotor.lambda_per_s,
        "side_modes_hz": [],
        "side_modes_decay_per_s": [],
        "z_residual_am2_per_s": None,
        "side_modes_visible": False,
    }
    if rotor.body is None:
        return out
    from sim_backend.rotor.rigid_body.dynamics import RigidBody

    small = RigidBody.of(rotor, ()).modes()
    moved = true_dm_dt(setup, result)
    residual = float(np.max(np.abs(z_residual(moved)), initial=0.0)) if moved.shape[1] > 1 else None
    return out | {
        "main_mode_hz": float(small.main.frequency_hz),
        "main_mode_decay_per_s": float(small.main.decay_per_s),
        "side_modes_hz": [float(m.frequency_hz) for m in small.sides],
        "side_modes_decay_per_s": [float(m.decay_per_s) for m in small.sides],
        "z_residual_am2_per_s": residual,
        "side_modes_visible": residual is not None and residual > VISIBLE_AM2_PER_S,
    }
