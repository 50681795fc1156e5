"""How the parameters of a fit follow a change of its data: the linear response of least squares.

d(theta) = P (J^T W J)^-1 J^T W d(y) with the Jacobian J of the fit at its solution, the weights W of the channels'
noise, and P from the fit's parameters to the published ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from platform_daemon.estimation.goodness_of_fit.residual_jacobian import derivatives_of
from platform_daemon.estimation.least_squares.public_parameters import public_jacobian
from platform_daemon.estimation.physics.trajectory.direct import Trajectory
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.result import FitResult

Array = NDArray[np.float64]
_POINTS = 16
"""Of a period of the second harmonic: 32 of the swing, so that no product of two of its first 15 harmonics is taken for
another one.  Means over as many samples would make the second harmonic smaller than the first, by 0.5 %, and the
sensitivities to a gain wrong by up to 8 %."""


@dataclass(frozen=True, eq=False)
class Response:
    """The linear response of one fit.

    Attributes:
        names: (m,) of the published parameters.
        odd, even: (3, n) the fitted dm/dt of odd and of even harmonics, some samples of it; slope: (3, n) its
            derivative per s.
        gains: (m, 3, n) d(parameter) / d(sample).
        left: (3, n) what the fit leaves over, in standard deviations of its noise; rows: (k, 3, n) the fit's Jacobian
            over the same, scaled to columns of length 1; noise: (3,) these standard deviations.
    """

    names: tuple[str, ...]
    odd: Array
    even: Array
    slope: Array
    gains: Array
    left: Array
    rows: Array
    noise: Array

    def beyond(self, change: Array) -> Array:
        """What no parameter of the fit follows of a change (3, n) of the data, in standard deviations of the noise."""
        scaled = (change / self.noise[:, None]).ravel()
        rows = self.rows.reshape(len(self.rows), -1)
        coefficients = np.linalg.lstsq(rows @ rows.T, rows @ scaled, rcond=None)[0]
        return np.asarray((scaled - coefficients @ rows).reshape(change.shape))

    def of(self, change: Array) -> Array:
        """Change of the parameters, (m,), for a change (3, n) of the data."""
        return np.asarray(np.tensordot(self.gains, change, 2), np.float64)

    def of_mixing(self, matrix: Array, signal: Array) -> Array:
        """Change of the parameters, (m,), for data that change by `matrix` (3, 3) times a signal (3, n)."""
        return self.of(matrix @ signal)


def response_of(fit: FitResult, record: RingDownRecord) -> Response:
    """The response of a good fit to the record (3, n) that it was made of."""
    assert fit.fitted is not None
    assert fit.window_s is not None
    model, state = fit.fitted.model, fit.fitted.state
    rate = record.sampling_rate_hz
    f_nat = fit.parameters["f_nat_hz"].value
    half = max(0, int(rate / (4.0 * f_nat * _POINTS) - 0.5))
    block = 2 * half + 1  # odd, so that a sample is in the middle of each
    place = -(-(record.valid_from + half) // block)
    first = place * block - half
    stop = min(record.samples.shape[1], record.valid_to or record.samples.shape[1], round(fit.window_s * rate))
    blocks = (stop - first) // block
    last = first + blocks * block

    trajectory = Trajectory(model, state.dynamics, (place + blocks) * block / rate)
    basis = trajectory.basis(first, last, 1.0 / rate, state.observation.observable)
    gains = state.observation.gains(state.dynamics.w)
    odd, even = gains[:, :1] * basis[0], gains[:, 1:] * basis[1]
    slope = np.gradient(odd + even, 1.0 / rate, axis=1)
    left = record.samples[:, first:last] - odd - even - state.offsets[:, None]
    own = left.reshape(len(left), blocks, block).mean(axis=2)
    deviations = own.std(axis=1)

    sd = fit.fitted.sd  # not that of the residual, which differs by some percent, and so would the response
    assert sd is not None
    free = _free(fit, len(state.dynamics.values), state.size)

    def rows_by(sd: Array) -> Array:
        found = derivatives_of(
            model, state, first=place, blocks=blocks, block=1, dt_s=block / rate, sd=sd, trajectory=trajectory
        )
        return found[free].reshape(int(free.sum()), -1)

    rows = rows_by(sd)
    white = np.array_equal(sd[:, 0], sd[:, 1])
    weighted = rows / sd[:, 0].repeat(blocks) if white else rows_by(sd**2)
    names, _, published = public_jacobian(model, state)
    scale = np.linalg.norm(rows, axis=1)  # columns of one size: the parameters have units
    triangle = np.asarray(np.linalg.qr((rows / scale[:, None]).T, mode="r"), np.float64)
    inverse = np.linalg.inv(triangle)  # of a few rows: solving for each of the samples takes longer than all the rest
    per_sample = (published[:, free] / scale @ inverse @ inverse.T / scale @ weighted).reshape(
        len(published), len(own), blocks
    )
    scaled_rows = (rows / scale[:, None]).reshape(len(rows), len(own), blocks)
    scaled_rows = scaled_rows * (sd[:, :1] / deviations[:, None])
    return Response(
        tuple(names),
        odd[:, half::block],
        even[:, half::block],
        slope[:, half::block],
        per_sample,
        own / deviations[:, None],
        scaled_rows,
        deviations,
    )


def _free(fit: FitResult, coefficients: int, size: int) -> NDArray[np.bool_]:
    """Which of the fit's own parameters were not held: phase, frequency, amplitude, coefficients, dipole, offsets."""
    assert fit.fitted is not None
    names = ["psi_start_rad", "f_nat_hz", "phi_max_rad", *(c.name for c in fit.fitted.model.coefficients), "m_r_am2"]
    free = np.ones(size, dtype=bool)
    for place, name in enumerate(names):
        free[place] = not fit.is_fixed(name)
    if fit.is_fixed("rodrigues_x"):
        free[4 + coefficients : 7 + coefficients] = False
    return free


def turned_to_rodrigues(rodrigues: Array) -> Array:
    """Derivative (3, 3) of a rotation vector, rad, by a small rotation about the world axes, rad.

    The inverse of the left Jacobian of the rotation group (Sola, Deray, Atchuthan, arXiv 1812.01537, eq. 146).
    """
    half = 0.5 * float(np.linalg.norm(rodrigues))
    x, y, z = rodrigues.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # (1 - h cot h) / (2 h)^2, whose series begins 1/12 + h^2/180
    square = (1.0 - half / math.tan(half)) / (4.0 * half**2) if half > 1e-3 else 1.0 / 12.0 + half**2 / 180.0
    return np.asarray(np.eye(3) - 0.5 * cross + square * cross @ cross)
