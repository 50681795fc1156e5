"""Lost samples, seen in the samples themselves, whatever the motion is."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from platform_daemon.diagnosis.selection.clock_gaps import filled_angles
from platform_daemon.diagnosis.selection.data_integrity import DataDefect, gap_in_words, merged
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, RATE, swing

NOISE, AT = 1e-3, 2950


def searched(angle, seed=0):
    noisy = angle + np.random.default_rng(seed).normal(0, NOISE, angle.size)
    record = RingDownRecord(noisy[None], RATE, "angle")
    with ThreadPoolExecutor(1) as pool:
        shots, found = filled_angles([DiagnosisShot("swing", record, estimate_noise(record))], pool)
    return shots[0].record.samples[0], [(defect.at, round(defect.value)) for defect in found]


@pytest.mark.parametrize(("lost", "dry"), [(1, 0.0), (1, 0.002), (3, 0.0), (20, 0.002), (100, 0.0), (100, 0.002)])
def test_a_loss_is_found_where_it_is_and_as_large_as_it_is(lost, dry):
    whole = swing(0.9, 30.0, dry=dry)
    filled, found = searched(np.delete(whole, slice(AT, AT + lost)))
    assert found == [(AT, lost)]
    assert filled[AT : AT + lost] == pytest.approx(whole[AT : AT + lost], abs=0.06)


@pytest.mark.parametrize("repeated", [1, 20])
def test_samples_that_stand_twice_are_told_as_such_and_left_out(repeated):
    whole = swing(0.9, 30.0)
    mended, found = searched(np.insert(whole, AT + repeated, whole[AT : AT + repeated]))
    assert found == [(AT + repeated, -repeated)]
    assert mended == pytest.approx(whole, abs=0.01)


def test_what_stands_twice_is_said_so():
    assert gap_in_words("a", 3, 7) == "a: 3 samples are missing before sample 7"
    assert gap_in_words("a", -3, 7) == "a: 3 samples stand twice, again from sample 7 on"


@pytest.mark.long
@pytest.mark.parametrize("viscous", [0.001, 0.02])
@pytest.mark.parametrize("dry", [0.0, 0.01, 0.03])
def test_no_loss_is_seen_in_torques(viscous, dry):
    assert searched(swing(1.2, 12.0, viscous=viscous, dry=dry))[1] == []


def test_a_kick_is_no_loss():
    quiet = swing(0.9, 30.0)
    late = np.arange(quiet.size) - AT
    kicked = quiet + np.where(late > 0, 0.05 * np.sin(2 * np.pi * NATURAL_HZ * 0.95 / RATE * late), 0.0)
    assert searched(kicked)[1] == []


def test_a_second_mode_is_no_loss():
    whole = swing(0.9, 30.0)
    time = np.arange(whole.size) / RATE
    beside = whole + 0.03 * np.exp(-time / 15.0) * np.sin(2 * np.pi * 1.6 * NATURAL_HZ * time)
    assert searched(beside)[1] == []


def test_a_loss_in_a_large_swing_that_waves_follow_only_for_a_short_time_is_found():
    assert searched(np.delete(swing(2.2, 30.0), slice(AT, AT + 2)))[1] == [(AT, 2)]


def test_losses_at_one_place_are_one():
    first = DataDefect(
        id="clock_gap",
        where="a: 24 samples are missing before sample 7",
        shot=0,
        at=7,
        value=23.54,
        sd=0.2,
        log_p=-50.0,
    )
    rest = DataDefect(
        id="clock_gap",
        where="a: -1 samples are missing before sample 7",
        shot=0,
        at=7,
        value=-0.996,
        sd=0.02,
        log_p=-20.0,
    )
    other = DataDefect(
        id="clock_gap", where="a: 2 samples are missing before sample 9", shot=0, at=9, value=2.0, sd=0.1, log_p=-30.0
    )
    one, two = merged([first, other, rest])
    assert (one.at, one.value, one.sd, one.where) == (
        7,
        pytest.approx(23.004),
        0.02,
        "a: 23 samples are missing before sample 7",
    )
    assert two == other
