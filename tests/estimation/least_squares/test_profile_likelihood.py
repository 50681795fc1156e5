"""The profile likelihood says the same as the covariance: chi2 rises by 1 at one standard deviation, by 4 at two."""

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.paper_datasets import DATASETS
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, dmdt, with_noise

CASES = [
    *(("JN50", name) for name in ("f_nat_hz", "lambda_per_s", "tf_over_i_rad_per_s2", "m_r_am2")),
    *(("TN50", name) for name in ("f_nat_hz", "lambda_per_s", "m_r_am2")),
]


def fit(name, fixed=None):
    variant, truth, seconds = DATASETS[name]
    record = RingDownRecord(with_noise(dmdt(truth, seconds), np.random.default_rng(5)), RATE_HZ, "dmdt")
    return fit_ring_down(record, variant, seconds, noise=NoiseModel.white(NOISE_SD, RATE_HZ), fixed=fixed)


def total_chi2(result):
    return result.chi2_per_dof * (3 * result.samples - len(result.covariance_names) - 3)


@pytest.mark.parametrize(("name", "parameter"), CASES)
def test_the_profile_likelihood_rises_as_the_standard_deviation_says(name, parameter):
    free = fit(name)
    estimate = free.parameters[parameter]
    for sigmas in (-2.0, -1.0, 1.0, 2.0):
        held = fit(name, {parameter: estimate.value + sigmas * estimate.std})
        rise = total_chi2(held) - total_chi2(free)
        assert np.sqrt(rise) == pytest.approx(abs(sigmas), rel=0.03)
