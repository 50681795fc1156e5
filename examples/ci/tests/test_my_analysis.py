"""The analysis against signals whose truth is known, and a script against a daemon."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from my_analysis import quality_factor

import platform_daemon as pd_
from platform_daemon.client import JobFailed
from platform_daemon.testing import assert_within
from platform_daemon.testing.processes import FaultyPlatform, RunningDaemon

Recordings = Callable[..., pd_.Recording]


def test_the_quality_factor_is_the_true_one(recording: Recordings) -> None:
    shot = recording("thread", rx_s=4.0, seed=7)
    true = math.pi * shot.truth["f_nat_hz"] / shot.truth["lambda_per_s"]
    assert quality_factor(shot) == pytest.approx(true, rel=1e-2)


def test_a_fit_is_within_its_errors(recording: Recordings) -> None:
    shot = recording("thread", rx_s=4.0, seed=7)
    assert_within(pd_.fit(shot), shot.truth, sigmas=5)


def test_a_script_measures(platform_daemon: RunningDaemon) -> None:
    with platform_daemon.client() as lab:
        fits = lab.measure("jewel", rx_s=0.6).wait(timeout_s=120).fits()
    assert fits.verdict.tolist() == ["good"]


def test_a_script_sees_that_a_device_does_not_answer(faulty_platform: Callable[..., FaultyPlatform]) -> None:
    lab = faulty_platform()
    lab.inject("deaf_link", device="lna")
    with lab.client() as client, pytest.raises(JobFailed):
        client.measure("jewel", rx_s=0.3).wait(timeout_s=120)
