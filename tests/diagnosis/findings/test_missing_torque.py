"""The map of the torque that is missing says nothing where nothing can be told."""

from types import SimpleNamespace

import numpy as np
import pytest

from platform_daemon.diagnosis.findings.missing_torque import missing_torque
from platform_daemon.diagnosis.selection.omnibus_test import OmnibusScore, OmnibusTest, powers

W, LARGEST = 2 * np.pi * 200.0, 0.7
FIT = SimpleNamespace(states=[SimpleNamespace(dynamics=SimpleNamespace(w=W))], noise_factor=1.0)


def left(told):
    """A test in which the declared parameters absorb all powers of angle and velocity but these."""
    shares = np.array([1.0 if each in told else 1e-4 for each in powers()])
    score = OmnibusScore(
        gain=30.0,
        directions=len(told),
        information=np.diag(shares),
        gradient=np.where(shares == 1.0, 2.0, 0.0),
        power=np.ones(shares.size),
    )
    return OmnibusTest(score, score, (LARGEST, 1.99 * np.sin(LARGEST / 2)))


def test_where_only_absorbed_powers_act_there_is_no_value_rather_than_zero():
    torque = missing_torque(FIT, left({(0, 1), (0, 3)}))  # of the velocity alone
    resting = np.abs(torque.phi_dot) < 1e-9
    moving = np.abs(torque.phi) < 1e-9
    assert np.isnan(torque.value[:, resting]).all()
    assert np.isnan(torque.std[:, resting]).all()
    assert np.isfinite(torque.value[moving][:, ~resting]).all()
    assert (torque.std[moving][:, ~resting] > 0).all()


def test_a_constant_that_is_told_is_told_everywhere_in_the_motion():
    torque = missing_torque(FIT, left({(0, 0)}))
    seen = np.isfinite(torque.value)
    assert seen[12].all()
    assert not seen[0, 0]
    assert torque.value[seen] == pytest.approx(2.0 * W**2)
    assert torque.std[seen] == pytest.approx(W**2)


def test_where_all_is_absorbed_there_is_no_map():
    assert missing_torque(FIT, left(set())) is None
