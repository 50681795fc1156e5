"""Springs are limited by their share of the restoring torque, whatever the amplitude."""

import pytest

from platform_daemon.diagnosis.effects.torque import SPRINGS, pendulum_candidates
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.models import THREAD


def largest(amplitude_rad):
    found = pendulum_candidates(THREAD, 1.0, 10.0, amplitude_rad)
    return {c.effect.id: c.largest for c in found if c.effect.id in SPRINGS}


@pytest.mark.parametrize("amplitude_rad", [0.045, 0.3, 1.0])
def test_a_spring_may_be_as_large_a_share_of_the_torque_in_a_small_swing(amplitude_rad):
    assert largest(amplitude_rad)["cubic_restoring"] * amplitude_rad**2 == pytest.approx(
        THRESHOLDS.effects.largest_cubic
    )


def test_limits_of_large_swings_and_of_a_torsion_do_not_move_with_the_amplitude():
    assert largest(2.0) == largest(1.0)
    assert largest(0.1)["torsion_stiffness"] == THRESHOLDS.effects.largest_torsion
