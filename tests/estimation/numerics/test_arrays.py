"""Small array routines against numpy."""

import numpy as np
import pytest

from platform_daemon.estimation.numerics.arrays import medians


@pytest.mark.parametrize("n", [1, 2, 7, 10])
def test_medians_are_those_of_numpy(n):
    values = np.random.default_rng(n).standard_normal((3, n))
    assert np.array_equal(medians(values), np.median(values, axis=1))
