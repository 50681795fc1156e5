"""Three swings of one specimen, of which one is dragged more: each has its own strength, and the odd one is told."""

import math

import numpy as np
import pytest

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, half_cycles

RATE, PERIODS = 100.0, 16


def dragged(drag, seed):
    s = 2.0 * math.pi * NATURAL_HZ * np.arange(int(PERIODS * RATE / NATURAL_HZ)) / RATE
    angle = half_cycles(lambda p, v, sigma, _: -math.sin(p) - 0.008 * v - drag * v * abs(v), 0.8, s, 1e-10)[0]
    record = RingDownRecord((angle + np.random.default_rng(seed).normal(0.0, 3e-4, s.size))[None], RATE, "angle")
    return DiagnosisShot(f"run {seed}", record, estimate_noise(record))


def report_on(*drags):
    return diagnosis_report(diagnose_shots([dragged(drag, seed) for seed, drag in enumerate(drags)], THREAD))


# A tenth more, which common strengths nearly explain; three times as much, where they explain nothing.
@pytest.mark.parametrize("odd", [0.022, pytest.param(0.06, marks=pytest.mark.long)])
def test_every_shot_has_its_own_strength_and_the_odd_one_is_told(odd):
    report = report_on(0.02, 0.02, odd)
    (drag,) = report.effects
    assert drag.id == "quadratic_drag"
    assert report.verdict in ("explained", "partly_explained")
    assert abs(drag.strength.value - np.mean([0.02, 0.02, odd])) < 0.02 * odd
    assert drag.strength.std == pytest.approx(np.std([0.02, 0.02, odd], ddof=1) / math.sqrt(3.0), rel=0.2)
    (told,) = [n for n in report.notes if "differs from shot to shot" in n]
    assert "run 2 is the odd one" in told
    # The model after is the one that was scored, and its parameters are those of this model.
    assert report.held_out.chi2_per_dof_after < 1.2
    assert report.parameters_after["lambda_per_s"].value == pytest.approx(0.004 * 2.0 * math.pi * NATURAL_HZ, rel=0.02)
    assert report.model_after.startswith("thread + quadratic_drag (0.0")


def test_strengths_that_do_not_differ_stay_common():
    report = report_on(0.02, 0.02, 0.02)
    assert [e.id for e in report.effects] == ["quadratic_drag"]
    assert report.effects[0].strength.std < 1e-4
    assert not any("differs from shot to shot" in n for n in report.notes)
