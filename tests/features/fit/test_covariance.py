"""The covariance of a fit: names of its rows, exact variances, nothing of what was held."""

import json
import math

import numpy as np
import pytest

from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.fits import FrameFit, unfitted
from platform_daemon.features.fit.fit import fit_stored_frame
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import open_measurement
from tests.kit.data import DATA

JEWEL = DATA / "example_jewel.mmr.h5"


@pytest.fixture(scope="module")
def fitted():
    """Free fit, and one with a held loss."""
    measurement = open_measurement(JEWEL)
    asks = FitRequest("jewel", 0.2), FitRequest("jewel", 0.2, fixed={"lambda_per_s": 0.2465})
    return [fit_stored_frame(measurement, 0, ask)[0] for ask in asks]


def test_the_diagonal_is_the_square_of_the_standard_deviations_to_the_last_bit(fitted):
    for fit in fitted:
        assert fit.good
        stds = [fit.parameters[name].std for name in fit.covariance.parameters]
        assert [row[k] for k, row in enumerate(fit.covariance.matrix)] == [std * std for std in stds]
        assert np.linalg.eigvalsh(np.array(fit.covariance.matrix) / np.outer(stds, stds)).min() > 0.0


def test_it_has_a_row_for_every_free_parameter_and_none_for_a_held_one(fitted):
    free, held = fitted
    assert free.covariance.parameters == tuple(free.parameters)
    assert held.covariance.parameters == tuple(name for name in free.parameters if name != "lambda_per_s")
    assert held.parameters["lambda_per_s"].std is None


def test_in_json_it_is_lists_of_finite_numbers_and_missing_for_a_refused_frame(fitted):
    found = json.loads(to_json(fitted[1]))["covariance"]
    size = len(found["parameters"])
    assert [len(row) for row in found["matrix"]] == [size] * size
    assert all(math.isfinite(value) for row in found["matrix"] for value in row)
    assert "covariance" not in json.loads(to_json(unfitted(0, "no signal")))


def test_a_result_of_an_earlier_version_is_read(fitted):
    before = json.loads(to_json(fitted[0]))
    del before["covariance"]
    assert FrameFit.model_validate(before).covariance is None
