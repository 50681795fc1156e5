"""The motion that a fit sees, against the basis it comes from."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.physics.models import JEWEL, THREAD
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE, STATE
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory


@pytest.mark.parametrize(("model", "values"), [(THREAD, (0.25,)), (JEWEL, (0.25, 900.0))])
@pytest.mark.parametrize("observable", [DIPOLE, STATE])
@pytest.mark.parametrize("block", [1, 23, 150])
def test_block_means_of_the_motion_are_those_of_its_basis(model, values, observable, block):
    d, dt_s, blocks = MotionParameters(w=2.0 * math.pi * 213.0, theta=1.3, amplitude=0.8, values=values), 1.6e-5, 40
    expected = Trajectory(model, d, (5 + block * blocks) * dt_s).basis(5, 5 + block * blocks, dt_s, observable)[:2]
    expected = expected.reshape(2, blocks, block).mean(axis=2)
    found = Workspace(model).block_means(
        d, begin=5, blocks=blocks, block=block, dt_s=dt_s, observable=observable, accuracy=0.0
    )
    assert np.allclose(found, expected, atol=3e-9)
