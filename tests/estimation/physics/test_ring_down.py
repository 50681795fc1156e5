"""Published parameters lead back to the very same motion."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.physics.ring_down import RingDown
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.paper_parameters import JEWEL_D30, THREAD_D30
from tests.kit.ring_down_generator import RATE_HZ, Truth, dmdt, rotation


@pytest.mark.parametrize("psi_deg", [0.0, 1e-6, 45.0, 90.0, 179.999, 180.0, 219.2, 270.0, 335.7, 359.999])
@pytest.mark.parametrize(("variant", "public"), [("thread", THREAD_D30), ("jewel", JEWEL_D30)])
def test_a_label_leads_to_the_trajectory_through_its_start_state(variant, public, psi_deg):
    psi, phi_max = math.radians(psi_deg), public["phi_max_rad"]
    ring_down = RingDown.from_parameters(variant, {**public, "psi_start_rad": psi})
    phi, v = ring_down.motion(1, 1e-4)
    assert phi[0] == pytest.approx(phi_max * math.cos(psi), abs=1e-12)
    assert v[0] == pytest.approx(-2.0 * math.sin(phi_max / 2) * math.sin(psi), abs=1e-12)
    assert ring_down.dynamics.theta >= 0.0


@pytest.mark.parametrize(("variant", "public"), [("thread", THREAD_D30), ("jewel", JEWEL_D30)])
def test_the_motion_is_that_of_an_independent_integrator(variant, public):
    friction = public.get("tf_over_i_rad_per_s2", 0.0)
    truth = Truth(**{k: v for k, v in public.items() if "rodrigues" not in k and "tf" not in k})
    truth = truth.with_(tf_over_i_rad_per_s2=friction, rodrigues=(0.0, 0.0, 0.0))
    ring_down = RingDown.from_parameters(variant, public)
    phi, v = ring_down.motion(6000, 1 / RATE_HZ)
    rate = ring_down.dynamics.w * v
    expected = dmdt(truth, 6000 / RATE_HZ)
    assert np.allclose(rotation(truth.rodrigues), np.eye(3))
    assert np.allclose(truth.m_r_am2 * rate * np.cos(phi), expected[1], atol=1e-8 * np.abs(expected).max())
    assert np.allclose(-truth.m_r_am2 * rate * np.sin(phi), expected[0], atol=1e-8 * np.abs(expected).max())


def test_a_fit_and_its_published_parameters_describe_the_same_ring_down():
    result = fit_ring_down(RingDownRecord(dmdt(Truth(), 0.25), RATE_HZ, "dmdt"), "thread", "n50")
    fitted = result.ring_down()
    published = RingDown.from_parameters("thread", {n: e.value for n, e in result.parameters.items()})
    for one, other in zip(fitted.motion(3000, 1e-4), published.motion(3000, 1e-4), strict=True):
        assert np.allclose(one, other, atol=1e-9)
    assert fitted.m_r_am2 == published.m_r_am2


def test_a_refused_fit_and_a_rotor_at_rest_describe_no_ring_down():
    noise = np.random.default_rng(1).standard_normal((3, 4000))
    with pytest.raises(ValueError, match="refused"):
        fit_ring_down(RingDownRecord(noise, RATE_HZ, "dmdt"), "thread", "n50").ring_down()
    with pytest.raises(ValueError, match="no oscillation"):
        RingDown.from_parameters("thread", {**THREAD_D30, "phi_max_rad": 0.0})
    with pytest.raises(KeyError):
        RingDown.from_parameters("jewel", THREAD_D30)


@pytest.mark.parametrize(("variant", "seconds"), [("thread", 12.0), ("jewel", 3.0)])
def test_turning_points_from_the_table_are_those_of_the_traced_motion(variant, seconds):
    values = {"f_nat_hz": 213.0, "lambda_per_s": 0.25, "phi_max_rad": 1.1, "psi_start_rad": 2.0}
    values |= {"tf_over_i_rad_per_s2": 1190.0} if variant == "jewel" else {}
    ring_down = RingDown.from_parameters(variant, values)
    times, peaks = ring_down._turning_points(seconds)  # noqa: SLF001 two ways that the public one chooses between
    traced_times, traced = ring_down._sampled_turning_points(seconds)  # noqa: SLF001 see above
    shared = min(times.size, traced_times.size)
    assert shared >= 2 * 213 * min(seconds, 1.5)
    np.testing.assert_allclose(peaks[:shared], traced[:shared], atol=1e-6)
    # The traced ones are found between samples, 64 a period.
    np.testing.assert_allclose(times[:shared], traced_times[:shared], atol=1 / (64 * 213.0))
    # The jewel sticks before the end: the last turning points are the same.
    if variant == "jewel":
        assert abs(times.size - traced_times.size) <= 1
