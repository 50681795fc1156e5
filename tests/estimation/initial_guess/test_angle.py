"""Angle records: start values from the data alone, from six periods on, up to 170 degrees."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import model_named
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.angle_cycles import find_angle_frequency, find_half_cycles
from tests.kit.pendulum import half_cycles


def random_record(seed):
    """(record, noise, variant, truth) of any frequency, amplitude, phase, loss and zero; some read in coarse steps."""
    rng = np.random.default_rng(seed)
    f, amplitude = 10 ** rng.uniform(math.log10(0.2), 3), math.radians(rng.uniform(5, 170)) * rng.choice([-1, 1])
    viscous, dry = 10 ** rng.uniform(-4.5, -1.6), rng.choice([0, 1]) * 10 ** rng.uniform(-4, -2.5) * abs(amplitude)
    points, periods = 10 ** rng.uniform(1.3, 2.5), rng.uniform(14, 40)
    s = rng.uniform(0, 2 * math.pi) + 2 * math.pi * np.arange(int(periods * points)) / points
    angle = half_cycles(lambda p, v, sigma, _: -math.sin(p) - 2 * viscous * v - sigma * dry, amplitude, s, 1e-11)[0]
    noise = 10 ** rng.uniform(-4, -1.5) * abs(amplitude)
    read = angle + rng.normal(0.1, noise, angle.size)
    if seed % 3 == 0:
        read = np.round(read / (2 * noise)) * 2 * noise
        noise *= math.sqrt(1 + 4 / 12)
    w = 2 * math.pi * f
    truth = {"f_nat_hz": f, "lambda_per_s": viscous * w, "coulomb_rad_per_s2": dry * w * w}
    record = RingDownRecord(read[None], f * points, "angle")
    variant = "jewel_constant_friction" if dry else "thread"
    return record, NoiseModel.white(np.array([noise]), record.sampling_rate_hz), variant, truth


@pytest.mark.parametrize("seed", range(24))
def test_a_pendulum_is_recovered_from_its_angle(seed):
    record, noise, variant, truth = random_record(seed)
    result = fit_ring_down(record, variant, 1e9, noise=noise)
    assert result.verdict == "good", result.reason
    assert result.chi2_per_dof == pytest.approx(1.0, abs=6 * math.sqrt(2 / result.samples))
    for name in result.covariance_names:
        if name in truth:
            estimate = result.parameters[name]
            assert abs(estimate.value - truth[name]) < 5 * estimate.std, name
    assert "m_r_am2" not in result.parameters


@pytest.mark.campaign
def test_many_pendulums_are_recovered_from_their_angles():
    failures = []
    for seed in range(1000, 1300):
        record, noise, variant, _ = random_record(seed)
        result = fit_ring_down(record, variant, 1e9, noise=noise)
        if result.verdict != "good" or result.chi2_per_dof > 1 + 6 * math.sqrt(2 / result.samples):
            failures.append((seed, result.reason, result.chi2_per_dof))
    print(failures)
    assert len(failures) <= 3


@pytest.mark.parametrize("phase_deg", [0.0, 1.0, 90.0, 179.0, 181.0, 270.0, 359.0])
def test_six_periods_are_enough_at_any_phase(phase_deg):
    s = math.radians(phase_deg) + 2 * math.pi * np.arange(1300) / 200
    angle = half_cycles(lambda p, v, sigma, _: -math.sin(p) - 0.02 * v - sigma * 1e-3, 1.0, s, 1e-11)[0]
    record = RingDownRecord((angle + np.random.default_rng(1).normal(0, 0.005, 1300))[None], 200.0, "angle")
    result = fit_ring_down(record, "jewel_constant_friction", 1e9)
    assert result.verdict == "good", result.reason
    assert abs(result.parameters["f_nat_hz"].value - 1.0) < 5 * result.parameters["f_nat_hz"].std


def test_passages_and_turning_points_are_found_in_coarse_steps_with_their_zero():
    s = 0.3 + 2 * math.pi * np.arange(2000) / 200
    angle = half_cycles(lambda p, v, sigma, _: -math.sin(p) - 0.02 * v, 1.5, s, 1e-11)[0] + 0.7
    coarse = np.round(angle / 0.05) * 0.05
    line = find_angle_frequency(coarse[None], 200.0)
    cycles = find_half_cycles(coarse, first=0, dt_s=1 / 200, frequency_hz=line.frequency_hz)
    assert cycles.zero_rad == pytest.approx(0.7, abs=0.02)
    assert np.all(np.diff(np.abs(cycles.turning_rad)) < 0.03)
    assert np.all(np.sign(cycles.turning_rad[1:]) == -np.sign(cycles.turning_rad[:-1]))
    assert np.diff(cycles.passages_s) == pytest.approx(0.5, abs=0.09)


@pytest.mark.parametrize("samples", [np.zeros(4000), np.random.default_rng(0).normal(size=4000), np.arange(4000.0)])
def test_what_does_not_swing_is_refused(samples):
    assert fit_ring_down(RingDownRecord(samples[None], 1000.0, "angle"), "thread", 1e9).verdict == "refused"


@pytest.mark.parametrize("periods", [8, 14, pytest.param(30, marks=pytest.mark.long)])
def test_errors_of_a_short_angle_record_are_honest_though_its_noise_was_not_given(periods):
    s = 0.7 + 2 * math.pi * np.arange(periods * 120) / 120
    angle = half_cycles(lambda p, v, sigma, _: -math.sin(p) - 0.01 * v, 1.0, s, 1e-11)[0]
    pulls = []
    for seed in range(25):
        noisy = angle + np.random.default_rng(seed).normal(0, 0.005, angle.size)
        result = fit_ring_down(RingDownRecord(noisy[None], 120.0, "angle"), "thread", 1e9)
        assert result.verdict == "good", result.reason
        assert "residual" in result.noise_source
        assert result.chi2_per_dof == pytest.approx(1.0, abs=0.02)
        known = fit_ring_down(
            RingDownRecord(noisy[None], 120.0, "angle"), "thread", 1e9, noise=NoiseModel.white(np.array([0.005]), 120.0)
        )
        f, true = result.parameters["f_nat_hz"], known.parameters["f_nat_hz"]
        assert f.std == pytest.approx(true.std, rel=5 / math.sqrt(2 * angle.size))
        pulls.append((f.value - 1.0) / f.std)
    assert 0.6 < np.std(pulls) < 1.5


@pytest.mark.parametrize(("excess", "speed", "floor"), [(0.3, 5.0, None), (0.4, 2.5, 0.05)])
def test_a_friction_that_falls_with_the_speed_is_fitted_whatever_that_speed(excess, speed, floor):
    w, rate = 2.0 * math.pi * 2.0, 200.0
    time = np.arange(int(20.0 * rate)) / rate
    angle = half_cycles(
        lambda p, v, sigma, _: (
            -math.sin(p) - 0.006 * v - sigma * ((floor or 0.0) + excess * math.exp(-abs(v) * w / speed)) / w**2
        ),
        0.6,
        w * time,
        1e-10,
    )[0]
    record = RingDownRecord((angle + np.random.default_rng(5).normal(0.0, 3e-4, time.size))[None], rate, "angle")
    terms = "thread+coulomb_friction" if floor else "thread"
    fit = fit_ring_down(record, model_named(f"{terms}+stribeck_coulomb_friction"))
    true = {"stribeck_coulomb_rad_per_s2": excess, "stribeck_coulomb_speed_rad_per_s": speed, "f_nat_hz": 2.0}
    for name, value in (true | ({"coulomb_rad_per_s2": floor} if floor else {})).items():
        found = fit.parameters[name]
        assert abs(found.value - value) < 4.0 * found.std, name
    assert fit.parameters["stribeck_coulomb_speed_rad_per_s"].std < 2.0 * speed
