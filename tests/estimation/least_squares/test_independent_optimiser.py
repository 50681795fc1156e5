"""Another optimiser, another integrator, differences for derivatives: the same estimates and the same errors."""

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.parameters import PARAMETER_NAMES
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, Truth, dmdt, random_truth, with_noise

RATE_HZ = 20e3
SECONDS = 0.12


def truth_of(names, vector):
    values = dict(zip(names, vector, strict=True))
    rodrigues = tuple(values.pop(f"rodrigues_{axis}") for axis in "xyz")
    return Truth(**values).with_(rodrigues=rodrigues)


def independent_fit(signal, names, start, fixed):
    """(values, standard deviations) by scipy's trust-region reflective method with three-point differences."""

    def residual(scaled):
        model = truth_of((*names, *fixed), (*(start + scaled * scale), *fixed.values()))
        miss = (dmdt(model, SECONDS, RATE_HZ, substeps=6) - signal) / NOISE_SD[:, None]
        # A constant offset per channel is free: it is linear, and best at the mean.
        return (miss - miss.mean(axis=1, keepdims=True)).ravel()

    scale = np.array([STEP[n] for n in names])
    found = least_squares(residual, np.zeros(len(names)), "3-point", x_scale="jac", xtol=1e-8, ftol=1e-10)
    covariance = np.linalg.inv(found.jac.T @ found.jac)
    return start + found.x * scale, scale * np.sqrt(np.diag(covariance))


STEP = {
    "f_nat_hz": 0.1, "m_r_am2": 1e-3, "lambda_per_s": 0.1, "tf_over_i_rad_per_s2": 100.0, "phi_max_rad": 0.1,
    "psi_start_rad": 0.1, "rodrigues_x": 0.1, "rodrigues_y": 0.1, "rodrigues_z": 0.1,
}  # fmt: skip


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.long) for n in range(1, 6))])
@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_an_independent_optimiser_agrees(variant, seed):
    rng = np.random.default_rng(1000 + seed)
    truth = random_truth(rng, variant, (150.0, 260.0), (15.0, 60.0))
    signal = with_noise(dmdt(truth, SECONDS, RATE_HZ), rng)
    # Both treatments of a jewel's losses: lambda held as in the paper's N50, and free.
    fixed = {"lambda_per_s": truth.lambda_per_s} if variant == "jewel" and seed % 2 else {}
    white = NoiseModel.white(NOISE_SD, RATE_HZ)
    result = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), variant, SECONDS, noise=white, fixed=fixed)
    assert result.verdict == "good", result.reason
    names = result.covariance_names
    estimate = np.array([result.parameters[n].value for n in names])
    std = np.sqrt(np.diag(result.covariance))
    # Started two standard deviations away, so that it has to find its own minimum.
    values, errors = independent_fit(signal, names, estimate + 2.0 * std * rng.choice([-1.0, 1.0], len(names)), fixed)
    apart = (values - estimate) / std
    print(variant, seed, "apart", np.abs(apart).max(), "errors", np.abs(errors / std - 1.0).max())
    assert np.all(np.abs(apart) < 0.05), dict(zip(names, apart, strict=True))
    assert np.all(np.abs(errors / std - 1.0) < 0.03), dict(zip(names, errors / std, strict=True))
    assert set(names) | set(fixed) == {n for n in PARAMETER_NAMES if variant == "jewel" or n[:2] != "tf"}
    assert math.isfinite(result.chi2_per_dof)
