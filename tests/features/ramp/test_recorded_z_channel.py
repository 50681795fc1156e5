"""The z channel of simulated shots, noise and all, against what the simulated world knows of its own z motion."""

import numpy as np
import pytest

from platform_daemon.features.ramp.z_residual import ZNoise, z_residual
from tests.kit.simulated_bench import CLOCK, Bench

RX = 61035  # 1 s
STEADY = {
    "noise__hum__enabled": True,
    "effects__friction_scatter__enabled": False,
    "effects__temperature__enabled": False,
    "effects__wear__enabled": False,
}


def recorded(bench, field_t):
    """dm/dt (3, n) of a shot from rest, as an exact calibration makes it, and the world's own z residual."""
    bench.backend.world.hold_still()
    volts = bench.shot(field_t, rx=RX, chunk=RX)
    setup, _ = bench.backend.world.shot_simulator.result()
    sensitivity = setup.lna_gain * setup.sensitivity_t_per_a
    return -np.linalg.inv(sensitivity) @ volts[:, setup.timeline.rx_start :], bench.truth()["z_residual_am2_per_s"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "fields_ut", "scale"),
    [
        pytest.param("thread_imperfect", (250, 280), 1, marks=pytest.mark.long),
        pytest.param("thread_imperfect", (280,), 3, marks=pytest.mark.long),
        ("jewel_imperfect", (600, 640), 1),
    ],
)
def test_what_is_found_is_the_worlds_own_z_residual_whether_it_lasts_or_is_over_in_20_ms(name, fields_ut, scale):
    bench = Bench(name, **{**STEADY, "noise__scale": float(scale)})
    noise = ZNoise.of([recorded(bench, 20e-6)[0] for _ in range(2)], CLOCK.rate_hz)
    assert z_residual(recorded(bench, 20e-6)[0], noise).size_am2_per_s == 0.0
    for field_ut in fields_ut:
        samples, truth = recorded(bench, 1e-6 * field_ut)
        found = z_residual(samples, noise)
        assert found.size_am2_per_s == pytest.approx(truth, rel=0.05, abs=4 * found.sd_am2_per_s)
        assert 1e-3 < found.sd_am2_per_s < 0.02 * scale
