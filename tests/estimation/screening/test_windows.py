"""Which samples a window takes."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.windows import select_window


def test_the_d30_window_ends_where_the_strongest_channel_has_30_percent_left():
    rate = 20000.0
    t = np.arange(60000) / rate
    signal = np.exp(-t) * np.sin(2 * np.pi * 200 * t) * np.array([[1.0], [5.0], [0.1]])
    chosen = select_window(RingDownRecord(signal, rate, "dmdt"), "d30", 200.0, np.full(3, 1e-9))
    assert chosen.last / rate == pytest.approx(-math.log(0.3), abs=0.01)
    assert chosen.notes == ()


def test_a_window_in_seconds_counts_from_time_zero():
    record = RingDownRecord(np.zeros((3, 1000)), 1000.0, "dmdt", valid_from=100)
    chosen = select_window(record, 0.5, 100.0, np.ones(3))
    assert (chosen.first, chosen.last) == (100, 500)


def test_n50_is_the_first_240_milliseconds():
    record = RingDownRecord(np.zeros((3, 1000)), 1000.0, "dmdt")
    assert select_window(record, "n50", 100.0, np.ones(3)).last == 240
