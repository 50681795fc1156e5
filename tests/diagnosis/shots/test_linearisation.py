"""The cache of a shot's bases, which fits of many threads share."""

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from platform_daemon.diagnosis.shots.linearisation import keep
from platform_daemon.diagnosis.thresholds import THRESHOLDS


@pytest.fixture
def threads_that_change_often():
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(usual)


@pytest.mark.usefixtures("threads_that_change_often")
def test_threads_that_keep_bases_of_one_shot_do_not_disturb_each_other():
    bases, one = {}, np.zeros(1)

    def fit(thread):
        for step in range(5000):
            keep(bases, (thread, step), one)

    with ThreadPoolExecutor(4) as pool:
        for _ in range(5):
            assert list(pool.map(fit, range(4))) == [None] * 4
    assert len(bases) == THRESHOLDS.shots.kept_bases
