"""Twins of many motions."""

import numpy as np

from platform_daemon.estimation.physics.mirror import nearest_mirror_images


def test_of_any_number_of_orientations_each_gets_the_twin_that_it_gets_alone():
    rng = np.random.default_rng(3)
    vectors, reference = rng.normal(0.0, 1.5, (1203, 3)), rng.normal(0.0, 1.0, 3)
    found, turned = nearest_mirror_images(vectors, reference)
    assert found.shape == (1203, 3)
    for k in (0, 499, 500, 999, 1202):
        alone, alone_turned = nearest_mirror_images(vectors[k : k + 1], reference)
        assert np.array_equal(found[k], alone[0])
        assert turned[k] == alone_turned[0]
    assert 100 < turned.sum() < 1103
