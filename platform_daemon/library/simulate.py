"""Signals of known truth, by the equation of motion that fits use.

The simulated platform of the daemon has another implementation of the physics, with the chain of devices, and is what
tests of the estimation use; this here is for trying an analysis, a window or a torque term of one's own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from drivers.errors import InputError
from platform_daemon.core.schemas.parameters import PAPER_NOISE_AM2_PER_S, RODRIGUES
from platform_daemon.core.settings import load_specimen
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.physics.models import model_named
from platform_daemon.estimation.physics.ring_down import RingDown
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.result import FitResult, FittedModel
from platform_daemon.features.fit.precision import expected_parameters
from platform_daemon.features.models.resolve import checked_variant

from .recording import Recording, from_arrays

RATE_HZ = 125e6 / 2048
"""Sampling rate of the platform of the paper, Hz."""
MOST_SECONDS = 600.0


def simulate(
    resonator: str,
    *,
    phi_max_deg: float,
    seconds: float,
    noise: Literal["paper"] | float | Sequence[float] | None = "paper",
    seed: int = 0,
    sampling_rate_hz: float = RATE_HZ,
    psi_start_deg: float = 0.0,
    model: str | None = None,
    terms: Sequence[str] = (),
    parameters: Mapping[str, float] | None = None,
) -> Recording:
    """A ring-down of a resonator as dm/dt, with white noise; `truth` of the recording has its parameters.

    Args:
        resonator: thread, jewel or the path of a resonator file, whose measured or design values it has.
        phi_max_deg: largest deflection, at the first sample, degrees, above 0 and below 90.
        seconds: length of the signal, s, at most 600.
        noise: standard deviation of one sample, A m^2/s, one number or one for each of x, y, z; "paper": that of the
            paper; None: no noise.
        seed: of the noise; the same seed gives the same signal.
        sampling_rate_hz: samples per second, Hz.
        psi_start_deg: phase at the first sample, degrees.
        model: equation of motion, None: that of the resonator's bearing; terms: further torque terms.
        parameters: values by public name, SI, in the place of the resonator's; a further term needs its own.

    Raises InputError for a resonator, model, term or parameter that is unknown, or a value that is impossible.
    """
    _check(phi_max_deg, seconds, sampling_rate_hz)
    specimen = load_specimen(resonator)[0]
    variant = checked_variant(model or specimen.variant, terms)
    truth = expected_parameters(specimen, math.radians(phi_max_deg), math.radians(psi_start_deg), variant, parameters)
    try:
        ring_down = RingDown.from_parameters(model_named(variant), truth)
    except ValueError as error:
        raise InputError(
            "this motion is impossible", where=variant, why=str(error), remedy="change its values"
        ) from None
    rotation = rotation_from_rodrigues(np.array([truth[name] for name in RODRIGUES]))
    state = FitState(ring_down.dynamics, DipoleObservation(truth["m_r_am2"], rotation, np.eye(3)), np.zeros(3))
    samples = round(seconds * sampling_rate_hz)
    exact = FitResult("good", fitted=FittedModel(ring_down.model, state)).model_signal(samples, sampling_rate_hz)
    sd = _levels(noise)
    noisy = exact if sd is None else exact + sd[:, None] * np.random.default_rng(seed).standard_normal(exact.shape)
    time_s = np.arange(samples) / sampling_rate_hz
    made = from_arrays(time_s, noisy, variant=specimen.variant, name=f"simulated {resonator}")
    return Recording(made.measurement, truth)


def _check(phi_max_deg: float, seconds: float, sampling_rate_hz: float) -> None:
    """Raises InputError."""
    if not 0 < phi_max_deg < 90:
        remedy = "give degrees above 0 and below 90"
        raise InputError(f"{phi_max_deg:g} deg is no deflection", where="phi_max_deg", remedy=remedy)
    if not 0 < seconds <= MOST_SECONDS:
        remedy = f"give seconds above 0, at most {MOST_SECONDS:g}"
        raise InputError(f"{seconds:g} s is no length", where="seconds", remedy=remedy)
    if not 100 <= sampling_rate_hz <= 1e6:
        remedy = "give 100 to 1000000 Hz"
        raise InputError(f"{sampling_rate_hz:g} Hz is no sampling rate", where="sampling_rate_hz", remedy=remedy)


def _levels(noise: Literal["paper"] | float | Sequence[float] | None) -> np.ndarray | None:
    """(3,) A m^2/s.  Raises InputError."""
    if noise is None:
        return None
    try:
        sd = np.asarray(PAPER_NOISE_AM2_PER_S if noise == "paper" else noise, dtype=np.float64)
        sd = np.broadcast_to(sd, (3,))
    except (TypeError, ValueError):
        sd = np.full(3, np.nan)
    if not (np.isfinite(sd).all() and (sd >= 0).all()):
        remedy = "give 'paper', one number, three numbers for x, y, z, or None"
        raise InputError(f"{noise!r} is no noise", where="noise", remedy=remedy)
    return sd
