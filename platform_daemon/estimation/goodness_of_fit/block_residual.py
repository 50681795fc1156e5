"""From a fitted state to its residual: block means of samples and motion, and the floor of an angle's noise."""

from __future__ import annotations

import math

import numpy as np
from scipy.fft import prev_fast_len

from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.noise.coloured import sd_at
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.frequency_search import block_means
from platform_daemon.estimation.screening.windows import SampleRange
from platform_daemon.estimation.thresholds import THRESHOLDS

from .noise_floor import POINTS_PER_PERIOD, NoiseFloor, noise_floor_of
from .residual import Residual

LIMITS = THRESHOLDS.goodness_of_fit


def residual_of(
    record: RingDownRecord,
    workspace: Workspace,
    state: FitState,
    *,
    chosen: SampleRange,
    noise: NoiseModel,
    noise_sd: Array,
) -> Residual:
    """The residual of a fitted state over its window; noise_sd (channels,) of single samples."""
    block = _block(record, state, LIMITS.block_points_per_period)
    sd = noise_sd / math.sqrt(block)
    data, model = _means(record, workspace, state, chosen, block, sd)
    floor = _floor(record, workspace, state, chosen) if record.quantity == "angle" else None
    return Residual(
        data=data - state.offsets[:, None],
        model=model,
        sd=sd,
        rate_hz=record.sampling_rate_hz / block,
        start_s=(chosen.first + 0.5 * (block - 1)) * record.dt_s,
        noise=noise,
        floor=floor,
        widening=1.0 if floor is None else _widening(floor, state, noise, noise_sd, record.sampling_rate_hz),
    )


def _block(record: RingDownRecord, state: FitState, points: float) -> int:
    """Samples in a block, of which there are so many in a period or a few more."""
    return max(1, int(record.sampling_rate_hz / _frequency_hz(state) / points))


def _means(
    record: RingDownRecord, workspace: Workspace, state: FitState, chosen: SampleRange, block: int, sd: Array
) -> tuple[Array, Array]:
    """Block means of the samples and of the fitted signal, (channels, blocks) each; sd (channels,): digits wanted."""
    blocks = (chosen.last - chosen.first) // block
    data = block_means(record.samples, chosen.first, block, blocks)
    gains = state.observation.gains(state.dynamics.w)
    if state.dynamics.theta >= 0.0 and not workspace.model.time_dependent:
        largest = abs(state.dynamics.amplitude) * float((np.abs(gains).max(axis=1) / sd).max())
        return data, gains @ workspace.block_means(
            state.dynamics,
            begin=chosen.first,
            blocks=blocks,
            block=block,
            dt_s=record.dt_s,
            observable=state.observation.observable,
            accuracy=1.0 / max(largest, 1.0),
        )
    # The tables know nothing of time, nor of what was before their first turning point.
    return data, gains @ _integrated(
        workspace.model,
        state.dynamics,
        first=chosen.first,
        blocks=blocks,
        block=block,
        dt_s=record.dt_s,
        observable=state.observation.observable,
    )


def _widening(floor: NoiseFloor, state: FitState, noise: NoiseModel, noise_sd: Array, rate_hz: float) -> float:
    """By how much the variances of an angle's fit are too small; the fit weighs with the noise at the fundamental."""
    sd = max(float(sd_at(noise, np.array([_frequency_hz(state)]), rate_hz)[0, 0]), float(noise_sd[0]))
    return floor.widening(sd, rate_hz)


def _frequency_hz(state: FitState) -> float:
    """Natural frequency."""
    return 0.5 * state.dynamics.w / math.pi


def _floor(record: RingDownRecord, workspace: Workspace, state: FitState, chosen: SampleRange) -> NoiseFloor | None:
    """What the residual of an angle tells of its noise."""
    block = _block(record, state, POINTS_PER_PERIOD)
    data, model = _means(
        record, workspace, state, chosen, block, np.full(1, LIMITS.probe_share * abs(state.dynamics.amplitude))
    )
    n = int(prev_fast_len(data.shape[1], real=True))
    return noise_floor_of((data - model)[0, :n], record.sampling_rate_hz / block, _frequency_hz(state))


def _integrated(
    model: RingDownModel,
    dynamics: MotionParameters,
    *,
    first: int,
    blocks: int,
    block: int,
    dt_s: float,
    observable: int,
) -> Array:
    """Block means (2, blocks) of the directly integrated motion, a stretch at a time."""
    trajectory = Trajectory(model, dynamics, (first + blocks * block) * dt_s)
    out = np.empty((2, blocks))
    for begin in range(0, blocks, LIMITS.block_chunk):
        end = min(begin + LIMITS.block_chunk, blocks)
        basis = trajectory.basis(first + begin * block, first + end * block, dt_s, observable)
        out[:, begin:end] = basis[:2].reshape(2, end - begin, block).mean(axis=2)
    return out
