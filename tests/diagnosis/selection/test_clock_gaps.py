"""Lost samples, seen in the samples themselves, whatever the motion is."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from platform_daemon.diagnosis import DiagnosisShot
from platform_daemon.diagnosis.selection.clock_gaps import filled_angles
from platform_daemon.estimation import RingDownRecord, estimate_noise
from tests.kit.pendulum import NATURAL_HZ, RATE, swing

NOISE, AT = 1e-3, 2950


def searched(angle, seed=0):
    noisy = angle + np.random.default_rng(seed).normal(0, NOISE, angle.size)
    record = RingDownRecord(noisy[None], RATE, "angle")
    with ThreadPoolExecutor(1) as pool:
        shots, found = filled_angles([DiagnosisShot("swing", record, estimate_noise(record))], pool)
    return shots[0].record.samples[0], [(defect.at, round(defect.value)) for defect in found]


@pytest.mark.parametrize("dry", [0.0, 0.002])
@pytest.mark.parametrize("lost", [1, 3, 20, 100])
def test_a_loss_is_found_where_it_is_and_as_large_as_it_is(lost, dry):
    whole = swing(0.9, 30.0, dry=dry)
    filled, found = searched(np.delete(whole, slice(AT, AT + lost)))
    assert found == [(AT, lost)]
    assert filled[AT : AT + lost] == pytest.approx(whole[AT : AT + lost], abs=0.06)


@pytest.mark.parametrize("viscous", [0.001, 0.02])
@pytest.mark.parametrize("dry", [0.0, 0.01, 0.03])
def test_no_loss_is_seen_in_torques(viscous, dry):
    assert searched(swing(1.2, 12.0, viscous=viscous, dry=dry))[1] == []


def test_a_kick_is_no_loss():
    quiet = swing(0.9, 30.0)
    late = np.arange(quiet.size) - AT
    kicked = quiet + np.where(late > 0, 0.05 * np.sin(2 * np.pi * NATURAL_HZ * 0.95 / RATE * late), 0.0)
    assert searched(kicked)[1] == []
