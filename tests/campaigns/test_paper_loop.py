"""The campaign on drawn effects can tell a right diagnosis from a wrong one; and one jewel that scipy has made."""

import math

import numpy as np
import pytest

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import model_named
from platform_daemon.estimation.record import RingDownRecord
from tests.campaigns.paper_loop import diagnosed_resonator, drawn_effects
from tests.kit.pendulum import half_cycles
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, with_noise

_F_NAT_HZ, _M_R_AM2, _LOSS_PER_S, _FRICTION, _SHARE, _TAU_S, _GAIN = 213.25, 0.012028, 0.0978, 1324.0, 0.15, 0.1, -0.03


def fluctuating_jewel(rng: np.random.Generator) -> np.ndarray:
    """dm/dt (3, n) of a jewel whose friction is an Ornstein-Uhlenbeck process, and whose y channel reads too little.

    The motion is scipy's, the process is drawn step by step; nothing of the simulated platform is in it.
    """
    step_s, w = 1e-3, 2.0 * math.pi * _F_NAT_HZ
    course = [rng.standard_normal()]
    keeps = math.exp(-step_s / _TAU_S)
    while len(course) < 2500:
        course.append(keeps * course[-1] + math.sqrt(1.0 - keeps**2) * rng.standard_normal())

    def torque(phi: float, v: float, side: float, s: float) -> float:
        place = s / (w * step_s)
        k = min(int(place), len(course) - 2)
        share = 1.0 + _SHARE * (course[k] + (place - k) * (course[k + 1] - course[k]))
        dry = _FRICTION / w**2 * share * max(math.cos(phi), 0.0) ** (4.0 / 3.0)
        return -math.sin(phi) - 2.0 * _LOSS_PER_S / w * v - side * dry

    s = rng.uniform(0.0, 6.0) + w * np.arange(round(1.6 * RATE_HZ)) / RATE_HZ
    phi, v = half_cycles(torque, 0.93, s, 1e-10)
    along, across = _M_R_AM2 * w * v * np.cos(phi), -_M_R_AM2 * w * v * np.sin(phi)
    return with_noise(np.stack([along, (1.0 + _GAIN) * across, 0.0 * along]), rng)


@pytest.mark.campaign
def test_a_friction_that_fluctuates_as_scipy_has_it_is_named_with_the_gain_beside_it():
    rng, noise = np.random.default_rng(5), NoiseModel.white(np.asarray(NOISE_SD), RATE_HZ)
    shots = [
        DiagnosisShot(f"shot {k}", RingDownRecord(fluctuating_jewel(rng), RATE_HZ, "dmdt"), noise, None, "jewel")
        for k in range(3)
    ]
    report = diagnosis_report(diagnose_shots(shots, model_named("jewel")))
    assert [e.id for e in report.effects] == ["friction_fluctuation", "channel_gain"]
    fluctuation, gain = (e.strength for e in report.effects)
    assert abs(fluctuation.value - _SHARE) < 4.5 * fluctuation.std
    assert abs(abs(gain.value) + _GAIN) < 0.002  # of y, or one of x that is as large, but for its square
    truth = {"f_nat_hz": _F_NAT_HZ, "lambda_per_s": _LOSS_PER_S, "tf_over_i_rad_per_s2": _FRICTION}
    for name, value in truth.items():
        found = report.parameters_after[name]
        assert abs(found.value - value) < 4.5 * found.std, name
    assert all(report.n50_d30[name].after_sigma < 4.5 for name in truth)


@pytest.mark.parametrize("variant", ["jewel", "thread"])
def test_effects_differ_and_are_those_of_their_bearing(variant):
    effects = [drawn_effects(variant, np.random.default_rng(seed)) for seed in range(20)]
    first = {w[0]["id"] for w in effects}
    fluctuations = {"friction_fluctuation", "frequency_fluctuation"}
    assert first == (fluctuations if variant == "jewel" else {"frequency_drift", "coulomb_friction"})
    assert {len(w) for w in effects} == {1, 2}
    assert len({w[0]["strength"] for w in effects}) == 20


@pytest.mark.campaign
def test_a_jewel_with_an_effect_is_judged():
    row = diagnosed_resonator("jewel", 1, 2)
    assert row.named
    assert row.agrees
    assert "agrees 1" in row.text()


@pytest.mark.campaign
@pytest.mark.parametrize(("variant", "seed"), [("jewel", 20), ("thread", 19)])
def test_what_was_wrong_of_drawn_effects_is_right(variant, seed):
    """m_r of the jewel did not span a gain of y, which is one of x; the thread's gain left lines that stood for it."""
    row = diagnosed_resonator(variant, seed, 3)
    assert row.named
    assert row.agrees
    assert not row.false
    assert row.farthest[0] < 3.0
