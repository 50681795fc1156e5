"""Angle records that scipy made, whole: what beside the torques, and in how few samples."""

from __future__ import annotations

import numpy as np
import pytest

from platform_daemon.diagnosis import DiagnosisShot, diagnose_shots, diagnosis_report
from platform_daemon.estimation import MODELS, RingDownRecord, estimate_noise
from tests.kit.pendulum import RATE, swing


def diagnosed(angle, noise, seed=1):
    read = angle + np.random.default_rng(seed).normal(0.0, noise, angle.size)
    record = RingDownRecord(read[None], RATE, "angle")
    found = diagnose_shots([DiagnosisShot("swing", record, estimate_noise(record))], MODELS["thread"])
    return diagnosis_report(found)


@pytest.mark.parametrize("mode_hz", [3.1, 9.2])
def test_a_second_mode_is_named_though_it_is_most_of_the_residual(mode_hz):
    angle = swing(0.8, 12.0)
    time = np.arange(angle.size) / RATE
    beside = angle + 4e-3 * np.exp(-time / 2.0) * np.cos(2.0 * np.pi * mode_hz * time)
    report = diagnosed(beside, 5e-4)
    (named,) = report.effects
    assert (report.verdict, named.id) == ("explained", "side_mode")
    assert named.detail.frequency_hz == pytest.approx(mode_hz, abs=0.02)


def test_dry_friction_is_named_in_few_samples():
    angle = swing(0.8, 12.0, dry=0.004)[:: round(RATE / 40.0)]
    read = angle + np.random.default_rng(2).normal(0.0, 2e-4, angle.size)
    record = RingDownRecord(read[None], 40.0, "angle")
    shot = DiagnosisShot("swing", record, estimate_noise(record))
    assert shot.noise.sd[0] == pytest.approx(2e-4, rel=0.4)
    report = diagnosis_report(diagnose_shots([shot], MODELS["thread"]))
    assert [e.id for e in report.effects] == ["coulomb_friction"]
