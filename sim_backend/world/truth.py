"""The truth of a shot, which only the simulation has, by the names of the paper and of the fit's report."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim_backend.receive.shot_setup import ShotSetup
from sim_backend.rotor.rotor import Rotor
from sim_backend.rotor.trajectory import energy_amplitude_rad, largest_angle_rad, states

from .shot import ShotResult
from .side_motion import side_record
from .variation import pressure_mbar

FLIP = np.diag([1.0, -1.0, -1.0])


def label(phi_rad: float, phi_dot_rad_per_s: float, omega_rad_per_s: float) -> tuple[float, float] | None:
    """phi_max and psi_start (rad) of the paper's label for a state (eq:dotvarphimax); None: there is no such label.

    phi = phi_max cos psi, phi' = -omega sqrt(2 - 2 cos phi_max) sin psi, psi in [0, 2 pi).  phi_max is not the
    peak angle, because the state is not on the orbit of phi_max.
    """
    speed = phi_dot_rad_per_s / (2 * omega_rad_per_s)
    if phi_rad == 0.0 and speed == 0.0:
        return 0.0, 0.0
    if abs(speed) >= 1.0 or abs(phi_rad) > np.pi:
        return None

    from scipy.optimize import brentq  # here: it takes long to load, and a plan that moves nothing does without

    def excess(phi_max: float) -> float:
        return float((phi_rad / phi_max) ** 2 + (speed / np.sin(phi_max / 2)) ** 2 - 1)

    low = max(abs(phi_rad), 2 * np.arcsin(abs(speed)))
    if excess(np.pi) > 0:
        return None
    phi_max = low if excess(low) <= 0 else float(brentq(excess, low, np.pi, xtol=1e-16, rtol=1e-15))
    psi = np.arctan2(-speed / np.sin(phi_max / 2), phi_rad / phi_max) % (2 * np.pi)
    return phi_max, float(psi) if psi < 2 * np.pi else 0.0


def pose(rotation: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Rodrigues vector (3,) rad in the fit's convention e_v . x > 0, and the sign that angles take in it.

    (phi, R) and (-phi, R turned by 180 deg about u) give the same signal; the convention picks one.
    """
    from scipy.spatial.transform import Rotation  # here for the same reason

    sign = -1.0 if rotation[0, 1] < 0 else 1.0
    turned = rotation if sign > 0 else rotation @ FLIP
    return np.asarray(Rotation.from_matrix(turned).as_rotvec()), sign


def record(setup: ShotSetup, result: ShotResult, temperature_c: float, violations: Iterable[Any]) -> dict[str, Any]:
    """The truth of one shot, plain JSON types; quantities that do not exist are None."""
    effects = setup.options.effects
    housing = setup.options.housing
    out: dict[str, Any] = {
        "seed": setup.options.seed,
        "shot": setup.number,
        "effects": {name: getattr(effects, name).enabled for name in type(effects).model_fields}
        | {"noise_colour": setup.options.noise.colour.enabled, "hum": setup.options.noise.hum.enabled},
        "undeclared": [effect.as_dict() for effect in setup.options.hidden_effects],
        "receive_chain": setup.options.receive.chain,
        "faults": sorted(setup.faults),
        "violations": list(violations),
        "temperature_c": temperature_c,
        "noise_sd_am2_per_s": _noise(setup, result),
        "peak_current_a": [_peak_a(setup, result, k) for k in range(3)],
        "hot_switch_a": _hot_switch_a(result),
        "variant": None,
    }
    if housing.swing_mbar:
        out["pressure_mbar"] = pressure_mbar(housing, setup.start_s)
    return out | (_rotor_record(setup, setup.rotor, result) if setup.rotor else {})


def _rotor_record(setup: ShotSetup, rotor: Rotor, result: ShotResult) -> dict[str, Any]:
    (x, y, z), sign = pose(rotor.rotation)
    omega = rotor.omega_rad_per_s
    tx_end = _state(setup, result, setup.timeline.tx_samples)
    rx_start = _state(setup, result, setup.timeline.rx_start)
    labels = label(sign * rx_start[0], sign * rx_start[1], omega) if rx_start else None
    amplitude = energy_amplitude_rad(*tx_end, omega) if tx_end else None
    return {
        "variant": rotor.variant,
        "f_nat_hz": rotor.f_nat_hz,
        "m_r_am2": rotor.m_r_am2,
        "lambda_per_s": rotor.lambda_per_s,
        "tf_over_i_rad_per_s2": rotor.tf_over_i_rad_per_s2,
        "rodrigues_x": float(x),
        "rodrigues_y": float(y),
        "rodrigues_z": float(z),
        "phi_max_rad": labels[0] if labels else None,
        "psi_start_rad": labels[1] if labels else None,
        "phi_rad": sign * rx_start[0] if rx_start else None,
        "phi_dot_rad_per_s": sign * rx_start[1] if rx_start else None,
        "amplitude_tx_end_rad": amplitude,
        "amplitude_tx_end_deg": float(np.degrees(amplitude)) if amplitude is not None else None,
        "amplitude_end_rad": energy_amplitude_rad(result.phi_rad, result.phi_dot_rad_per_s, omega),
        "stuck_at_end": result.stuck,
        "contact_lost": rotor.variant == "jewel" and largest_angle_rad(result.pieces) > np.pi / 2,
        "inertia_kg_m2": rotor.inertia_kg_m2,
        "b_0_t": rotor.b_0_t,
    } | side_record(setup, result)


def _state(setup: ShotSetup, result: ShotResult, sample: int) -> tuple[float, float] | None:
    """Angle and speed at a sample; None if the shot was stopped before."""
    time_s = sample / setup.timeline.clock.rate_hz
    if time_s > setup.stop_s:
        return None
    phi, phi_dot = states(result.pieces, np.array([time_s]))
    return float(phi[0]), float(phi_dot[0])


def _noise(setup: ShotSetup, result: ShotResult) -> list[float]:
    """rms of -P^-1 applied to the noise, one value per world axis, A m^2/s."""
    inverse = np.linalg.inv(setup.lna_gain * setup.sensitivity_t_per_a)
    return [float(v) for v in np.sqrt((inverse**2) @ result.received.noise_sd_v**2)]


def _peak_a(setup: ShotSetup, result: ShotResult, coil: int) -> float:
    """Largest current of a coil, A, on the ADC's time grid."""
    peaks = [
        np.max(np.abs(cut.current_a(coil, np.arange(cut.start_s, cut.stop_s, 1 / setup.timeline.clock.rate_hz))))
        for cut in result.cuts
        if cut.currents[coil]
    ]
    return float(max(peaks, default=0.0))


def _hot_switch_a(result: ShotResult) -> float:
    """Largest current at the moment at which the contacts left TRANSMIT, A."""
    leaving = [a for a, b in pairwise(result.cuts) if any(a.currents) and b.position is not a.position]
    return max((abs(float(c.current_a(k, np.array([c.stop_s]))[0])) for c in leaving for k in range(3)), default=0.0)
