"""The z residual of noisy records: what is there is found at its size, what is noise or hum is not."""

import numpy as np
import pytest

from platform_daemon.features.ramp.z_residual import ZNoise, z_residual

RATE, N, NOISE = 61035.0, 61035, (0.014, 0.021, 0.055)
TIME = np.arange(N) / RATE


def record(seed, scale=1.0, side=0.0, hum=0.0, swing=6.0):
    """dm/dt of a main mode that leaks into z, one decaying side mode, hum of random phase, and white noise."""
    rng = np.random.default_rng(seed)
    main = swing * np.exp(-0.25 * TIME) * np.sin(2 * np.pi * 214.0 * TIME)
    other = 0.2 * swing * np.exp(-0.5 * TIME) * np.cos(2 * np.pi * 428.0 * TIME)
    z = 0.02 * main - 0.05 * other + side * np.exp(-3.0 * TIME) * np.sin(2 * np.pi * 137.3 * TIME)
    z = z + hum * np.sin(2 * np.pi * (50.0 * TIME + rng.uniform()))
    noise = scale * np.array(NOISE)[:, None] * rng.standard_normal((3, N))
    return np.stack([main, other, z]) + noise


def noise_of(scale=1.0, hum=0.0):
    return ZNoise.of([record(900 + k, scale, hum=hum, swing=2.0) for k in range(3)], RATE)


@pytest.mark.parametrize("scale", [1.0, 3.0, 10.0])
def test_noise_and_hum_are_no_side_modes(scale):
    noise = noise_of(scale, hum=0.1)
    sizes = [z_residual(record(k, scale, hum=0.1), noise).size_am2_per_s for k in range(25)]
    assert max(sizes) < 0.05 * scale
    assert np.count_nonzero(sizes) <= 2


@pytest.mark.parametrize(("scale", "tolerance"), [(1.0, 0.05), (3.0, 0.1), (10.0, 0.25)])
def test_a_decaying_line_is_found_at_its_size_and_its_frequency(scale, tolerance):
    noise = noise_of(scale, hum=0.05)
    found = [z_residual(record(k, scale, side=0.4, hum=0.05), noise) for k in range(10)]
    sizes = np.array([f.size_am2_per_s for f in found])
    assert sizes.mean() == pytest.approx(0.4, rel=tolerance)
    assert sizes.std() < 3.0 * max(f.sd_am2_per_s for f in found)
    assert {round(f.lines[0].frequency_hz) for f in found} == {137}


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(ValueError, match="blank shot"):
        ZNoise.of([], RATE)
    with pytest.raises(ValueError, match="61035"):
        z_residual(record(0)[:, :1000], noise_of())
