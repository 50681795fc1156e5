"""A kick must show in the few periods around its instant."""

import numpy as np
import pytest

from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.selection.kick_search import kick_missing, kicks
from platform_daemon.diagnosis.selection.refits import refined, refit
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import RATE, kicked, swing


def with_a_kick(angle, noise=3e-4):
    """The declared model with the likeliest kick, fitted to an angle."""
    read = angle + np.random.default_rng(1).normal(0.0, noise, angle.size)
    record, pool = RingDownRecord(read[None], RATE, "angle"), InlineExecutor()
    prepared, _ = initial_fits([DiagnosisShot("swing", record, estimate_noise(record))], THREAD, pool)
    base = fit_jointly(prepared, Hypothesis(THREAD), pool)
    fitted = refit(base.hypothesis.plus(kicks(base)[0]), base, pool)
    assert fitted is not None
    return base, refined(fitted, pool)


@pytest.mark.parametrize("change", [1e-3, pytest.param(2e-2, marks=pytest.mark.long)])
def test_a_kick_shows_at_its_instant(change):
    assert not kick_missing(with_a_kick(kicked(0.8, 15.0, at_period=7.3, change=change))[1])


def test_what_friction_is_wrong_by_is_no_kick():
    base, fitted = with_a_kick(swing(0.8, 15.0, dry=0.004))
    assert fitted.chi2 < 0.8 * base.chi2
    assert kick_missing(fitted)
