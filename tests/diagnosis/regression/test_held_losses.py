"""A loss that is held takes no step, however much alike the other parameters are."""

import numpy as np

from platform_daemon.diagnosis.regression.cross_validation import least_squares_step


def test_a_loss_that_is_held_takes_no_step():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        columns = rng.normal(size=(200, 6))
        columns[:, 1] = columns[:, 0] + 1e-4 * columns[:, 1]
        columns[:, 4] = columns[:, 5] + 1e-3 * columns[:, 4]
        columns[:, 3] = 0.0
        step, fall = least_squares_step(columns, rng.normal(size=200))
        assert abs(step[3]) < 1e-6  # it was a rounding error over 1e-300
        assert fall > 0.0
