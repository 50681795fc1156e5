"""Harmonics against exact orbits, against drifting ring-downs, and against the fit."""

import math

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from platform_daemon.estimation.cramer_rao import MeasurementPlan, predict_precision
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.harmonic_estimator.demodulation import second_harmonic
from platform_daemon.estimation.harmonic_estimator.estimator import estimate_from_harmonics
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.orbit import first_harmonic, frequency_ratio
from platform_daemon.estimation.physics.ring_down import RingDown
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import RefusedError
from platform_daemon.features.fit.series.orientation import error_angle
from tests.kit.harmonic_bias import bias_against_fit
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, random_truth, rotation, with_noise

TILTED = (0.3, -0.2, -1.3)


def record_of(signal, rate_hz=RATE_HZ):
    return RingDownRecord(signal, rate_hz, "dmdt")


def truth_at(degrees, friction=0.0, **changes):
    base = Truth(f_nat_hz=213.0, phi_max_rad=math.radians(degrees), psi_start_rad=1.0, rodrigues=TILTED)
    return base.with_(tf_over_i_rad_per_s2=friction, **changes)


def orbit(degrees, f_nat_hz=213.0, m_r=0.012, phase=0.7, seconds=0.2):
    """dm/dt of the undamped orbit from Jacobi's functions, not from any integrator."""
    k2 = math.sin(math.radians(degrees) / 2) ** 2
    w = 2 * math.pi * f_nat_hz
    s = w * np.arange(round(seconds * RATE_HZ)) / RATE_HZ + phase
    sn, cn, dn, _ = ellipj(s, k2)
    half, rate = math.sqrt(k2) * sn, 2 * math.sqrt(k2) * w * cn  # sin(phi/2), phi'
    sin_phi, cos_phi = 2 * half * dn, 1 - 2 * half**2
    r = rotation(TILTED)
    return m_r * (r[:, [1]] * rate * cos_phi - r[:, [0]] * rate * sin_phi)


@pytest.mark.parametrize("degrees", [10.0, 20.0, 30.0, 45.0, 60.0])
@pytest.mark.parametrize("phase", [0.0, 0.7, 2.9])
def test_an_undamped_orbit_is_read_exactly(degrees, phase):
    found = estimate_from_harmonics(record_of(orbit(degrees, phase=phase)))
    assert found.f_nat_hz == pytest.approx(213.0, abs=1e-4)
    assert found.frequency_hz == pytest.approx(213.0 * frequency_ratio(math.radians(degrees)), abs=1e-4)
    assert found.amplitude_rad == pytest.approx(math.radians(degrees), rel=2e-6)
    assert found.m_r_am2 == pytest.approx(0.012, rel=5e-6)
    assert error_angle(found.rodrigues, TILTED) < 1e-6
    assert found.decay_per_s == pytest.approx(0.0, abs=1e-3)


ORBITS = [
    (10, 0.0874, 0.998096),
    (22, 0.1930, 0.990792),
    (30, 0.2645, 0.982889),
    (53, 0.4778, 0.946738),
    (90, 0.8691, 0.847213),
]


# u_2 has 1 - q^2 in its denominator; with (1 + q)^2, as also published, it would lack 2.7 % at 53 degrees.
@pytest.mark.parametrize(("degrees", "ratio", "frequency"), ORBITS)
def test_the_elliptic_relations_are_those_of_the_exact_orbit(degrees, ratio, frequency):
    amplitude = math.radians(degrees)
    assert second_harmonic(amplitude) / first_harmonic(amplitude) == pytest.approx(ratio, abs=6e-5)
    assert frequency_ratio(amplitude) == pytest.approx(frequency, abs=1e-6)
    k2 = math.sin(amplitude / 2) ** 2
    s = 4 * ellipk(k2) * np.arange(4096) / 4096
    sn, cn, dn, _ = ellipj(s, k2)
    v = 2 * math.sqrt(k2) * cn
    by_sum = [
        np.abs(np.fft.rfft(x)[k]) * 2 / 4096
        for x, k in ((v * (1 - 2 * k2 * sn**2), 1), (2 * v * math.sqrt(k2) * sn * dn, 2))
    ]
    assert (first_harmonic(amplitude), second_harmonic(amplitude)) == pytest.approx(by_sum, rel=1e-10)


@pytest.mark.parametrize("degrees", [10.0, 23.0, 45.0, 60.0])
def test_viscous_damping_is_recovered_at_any_amplitude(degrees):
    found = estimate_from_harmonics(record_of(dmdt(truth_at(degrees, lambda_per_s=0.5), 0.2)))
    assert found.lambda_per_s == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("degrees", [23.0, 53.0])
def test_friction_appears_as_the_decay_of_the_envelope(degrees):
    truth = truth_at(degrees, 1300.0)
    found = estimate_from_harmonics(record_of(dmdt(truth, 0.2)))
    public = {
        n: getattr(truth, n)
        for n in ("f_nat_hz", "lambda_per_s", "tf_over_i_rad_per_s2", "phi_max_rad", "psi_start_rad")
    }
    around = RingDown.from_parameters("jewel", public).peak_rate(found.time_s + np.array([-0.01, 0.0, 0.01]))
    assert found.decay_per_s == pytest.approx(math.log(around[0] / around[2]) / 0.02, rel=3e-3)
    assert found.amplitude_rad == pytest.approx(2 * math.asin(around[1] / 2), rel=2e-4)
    start = 2 * math.asin(RingDown.from_parameters("jewel", public).peak_rate(np.array([0.0]))[0] / 2)
    assert found.amplitude_at_start_rad == pytest.approx(start, rel=4e-3)
    assert found.chirp_hz_per_s > 0.0


# (degrees, T_f/I): sweep/Hz, f_nat/Hz, m_r/%, A/deg, the table of the module's docstring.
BIAS = [
    (53, 0.0, 0.68, 0.0002, -0.0001, 0.001),
    (53, 500.0, 1.28, 0.0004, -0.0002, 0.002),
    (53, 1300.0, 2.19, 0.0004, -0.0002, 0.002),
    (53, 3000.0, 4.01, 0.0002, 0.0000, 0.001),
    (53, 6000.0, 6.75, -0.0016, 0.0030, -0.009),
    (53, 10000.0, 9.46, -0.0069, 0.0305, -0.037),
    (23, 0.0, 0.12, 0.0000, -0.0000, 0.000),
    (23, 500.0, 0.38, 0.0001, -0.0000, 0.001),
    (23, 1300.0, 0.76, 0.0000, 0.0002, 0.002),
    (23, 3000.0, 1.42, -0.0009, 0.0055, 0.002),
    (23, 6000.0, 2.07, -0.0100, 0.2277, -0.027),
    (23, 10000.0, 2.14, -0.1663, 15.5, -0.882),
]


@pytest.mark.parametrize(("degrees", "friction", "sweep", "f_nat", "m_r", "amplitude"), BIAS)
def test_the_bias_against_the_fit_is_the_documented_one(degrees, friction, sweep, f_nat, m_r, amplitude):
    record = record_of(dmdt(truth_at(degrees, friction), 0.25))
    variant = "jewel" if friction else "thread"
    fit = fit_ring_down(record, variant, 0.24, noise=NoiseModel.white(NOISE_SD, RATE_HZ))
    assert fit.verdict == "good", fit.reason
    bias = bias_against_fit(estimate_from_harmonics(record), fit)
    found = (bias.sweep_hz, bias.f_nat_hz, 100 * bias.m_r_relative, math.degrees(bias.amplitude_rad))
    print(degrees, friction, *(f"{x:+.4f}" for x in found), f"{math.degrees(bias.orientation_rad):.1e}")
    assert found[0] == pytest.approx(sweep, abs=0.011)
    for value, expected, resolution in zip(found[1:], (f_nat, m_r, amplitude), (2e-4, 2e-4, 2e-3), strict=True):
        assert value == pytest.approx(expected, abs=resolution, rel=0.02)
    assert math.degrees(bias.orientation_rad) < 1e-4


@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_any_orientation_phase_and_frequency_needs_no_start_values(variant):
    for seed in range(12):
        rng = np.random.default_rng(seed)
        truth = random_truth(rng, variant, (120.0, 600.0), (15.0, 65.0))
        found = estimate_from_harmonics(record_of(with_noise(dmdt(truth, 0.25), rng)))
        assert found.f_nat_hz == pytest.approx(truth.f_nat_hz, rel=3e-4), seed
        assert found.m_r_am2 == pytest.approx(truth.m_r_am2, rel=0.01), seed
        assert error_angle(found.rodrigues, np.array(truth.rodrigues)) < math.radians(0.5), seed


def test_the_scatter_is_within_twice_the_bound_of_the_same_samples():
    truth = truth_at(22.8)
    signal, rng = dmdt(truth, 0.13), np.random.default_rng(3)
    found = [estimate_from_harmonics(record_of(with_noise(signal, rng))) for _ in range(100)]
    public = {n: truth.value(n) for n in ("f_nat_hz", "m_r_am2", "lambda_per_s", "phi_max_rad", "psi_start_rad")}
    public |= dict(zip(("rodrigues_x", "rodrigues_y", "rodrigues_z"), TILTED, strict=True))
    bound = predict_precision(MeasurementPlan("thread", public, NOISE_SD, RATE_HZ), found[0].stretch_s)
    for name in ("f_nat_hz", "m_r_am2"):
        values = np.array([getattr(e, name) for e in found])
        assert 0.8 < values.std() / bound.sd[name] < 2.0
        assert abs(values.mean() - truth.value(name)) < 5.0 * values.std() / 10.0
    angles = [error_angle(e.rodrigues, TILTED) for e in found]
    assert np.sqrt(np.mean(np.square(angles))) < 2.0 * bound.orientation_rad


def test_an_offset_and_the_rest_of_the_record_do_not_matter():
    signal = dmdt(truth_at(30.0), 1.0)
    short = estimate_from_harmonics(record_of(signal[:, :15000]))
    long = estimate_from_harmonics(record_of(signal + np.array([[1.0], [-2.0], [0.5]])))
    assert long.f_nat_hz == pytest.approx(short.f_nat_hz, abs=1e-3)
    assert long.m_r_am2 == pytest.approx(short.m_r_am2, rel=1e-4)
    later = estimate_from_harmonics(RingDownRecord(signal, RATE_HZ, "dmdt", valid_from=3000))
    assert later.time_s == pytest.approx(long.time_s + 3000 / RATE_HZ, abs=1e-3)
    assert later.amplitude_at_start_rad == pytest.approx(short.amplitude_at_start_rad, rel=2e-3)


def test_what_cannot_be_read_is_refused_by_name():
    rng = np.random.default_rng(4)
    signal = dmdt(truth_at(22.8), 0.2)
    with pytest.raises(RefusedError, match="too_short"):
        estimate_from_harmonics(record_of(signal[:, :4000]))
    with pytest.raises(RefusedError, match="no_signal"):
        estimate_from_harmonics(record_of(rng.standard_normal((3, 12000))))
    with pytest.raises(RefusedError, match="amplitude_below_floor"):
        estimate_from_harmonics(record_of(with_noise(dmdt(truth_at(2.0), 0.2), rng, 10 * NOISE_SD)))
    with pytest.raises(RefusedError, match="not_finite"):
        estimate_from_harmonics(record_of(np.where(np.arange(signal.shape[1]) == 100, np.nan, signal)))
    with pytest.raises(ValueError, match="volts"):
        estimate_from_harmonics(RingDownRecord(signal, RATE_HZ, "voltage"))
    with pytest.raises(ValueError, match="refused"):
        bias_against_fit(estimate_from_harmonics(record_of(signal)), fit_ring_down(record_of(0 * signal), "thread"))
