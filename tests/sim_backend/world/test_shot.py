"""Whole shots on the shipped configuration."""

import numpy as np
import pytest

from sim_backend.rotor.rotor import effective
from sim_backend.rotor.trajectory import energy_amplitude_rad
from tests.kit.rotor_reference import swing
from tests.kit.simulated_bench import CLOCK, FIELD_T, QUIET, SWITCH, TX, Bench, specimen

STEADY = {k: v for k, v in QUIET.items() if k.startswith("effects")}


def reference_amplitude_deg(name):
    """The same zero-phase sine field on the same rotor, integrated by scipy."""
    rotor, omega = effective(specimen(name)), 2 * np.pi * 10 * CLOCK.rate_hz / TX
    _, _, phi, phi_dot = swing(
        TX / CLOCK.rate_hz, 0.0, 0.0, lam=rotor.lambda_per_s, w=rotor.omega_rad_per_s, tf=rotor.tf_over_i_rad_per_s2,
        m_i=rotor.m_r_am2 / rotor.inertia_kg_m2, b=lambda t: (0.0, FIELD_T[name] * np.sin(omega * t)), rtol=1e-10,
    )  # fmt: skip
    return np.degrees(energy_amplitude_rad(phi, phi_dot, rotor.omega_rad_per_s))


@pytest.mark.parametrize(("name", "about_deg"), [("thread", 22.7), ("jewel", 55.9)])
def test_deflection_at_the_papers_fields_equals_an_independent_integration(name, about_deg):
    bench = Bench(name, **STEADY)
    bench.shot(rx=100)
    found = bench.truth()["amplitude_tx_end_deg"]
    assert found == pytest.approx(reference_amplitude_deg(name), abs=0.05)
    assert found == pytest.approx(about_deg, abs=0.1)
    assert bench.truth()["contact_lost"] is False


def amplitudes_uv(name):
    """Start amplitudes of dm/dt along v and u at the first RX sample, noise-free, as peaks over the first 10 ms."""
    bench = Bench(name, **QUIET)
    volts = bench.shot(rx=610)[:, TX + SWITCH :]
    rate = -np.linalg.solve(bench.calibration.sensitivity, volts)
    u_v = effective(specimen(name)).rotation[:, :2].T @ rate
    return np.abs(u_v).max(axis=1)


def test_start_amplitudes_of_jewel_and_thread_stand_in_the_ratio_of_the_shipped_parameters():
    (u_thread, v_thread), (u_jewel, v_jewel) = amplitudes_uv("thread"), amplitudes_uv("jewel")
    assert v_thread == pytest.approx(6.0, rel=0.1)
    assert 2.2 < v_jewel / v_thread < 2.6
    assert 5.3 < u_jewel / u_thread < 5.9


def test_levels_fit_the_hardware():
    for name, volts in (("thread", 0.24), ("jewel", 0.6)):
        bench = Bench(name)
        peak = np.abs(bench.shot(rx=610)[0, TX + SWITCH :]).max()
        assert peak == pytest.approx(volts, rel=0.15)
        assert bench.truth()["peak_current_a"][0] < 0.5
        assert not bench.amplifier.status().clipped
        assert not bench.lna.overloaded()


def test_first_shot_starts_at_rest_and_a_long_wait_brings_the_rotor_back_to_rest():
    bench = Bench("thread", **STEADY)
    bench.shot(rx=610)
    first = bench.truth()["amplitude_tx_end_deg"]
    bench.clock.sleep(150.0)
    bench.shot(rx=610)
    assert bench.truth()["amplitude_tx_end_deg"] == pytest.approx(first, rel=1e-12)


@pytest.mark.parametrize(("pause_s", "disturbed"), [(0.5, True), (30.0, False)])
def test_a_too_short_wait_disturbs_the_next_shot(pause_s, disturbed):
    bench = Bench("thread", **STEADY)
    bench.shot(rx=610)
    first = bench.truth()
    bench.clock.sleep(pause_s)
    bench.shot(rx=610)
    change = abs(bench.truth()["phi_max_rad"] / first["phi_max_rad"] - 1)
    assert (change > 0.05) == disturbed


def test_decay_during_a_pause_equals_decay_during_a_shot():
    bench, other = Bench("thread", **STEADY), Bench("thread", **STEADY)
    bench.shot(rx=610)
    other.shot(rx=610 + 61035 * 2)
    other.switch.to_transmit()
    bench.clock.sleep(other.clock.monotonic_s() - bench.clock.monotonic_s())
    for each in (bench, other):
        each.shot(rx=610)
    assert bench.truth()["phi_rad"] == pytest.approx(other.truth()["phi_rad"], rel=1e-8)


def test_jewel_sticks_before_its_two_seconds_are_over():
    bench = Bench("jewel", **STEADY)
    bench.shot(rx=2 * 61035)
    truth = bench.truth()
    assert truth["stuck_at_end"]
    assert truth["amplitude_end_rad"] < np.radians(0.05)


def test_an_absurd_field_lifts_the_jewel_beyond_ninety_degrees_and_the_truth_says_so():
    bench = Bench("jewel", **STEADY, card__output_full_scale_v=10.0, amplifier__limit_v=90.0)
    bench.shot(field_t=8e-3, rx=610)
    assert bench.truth()["contact_lost"] is True


def test_blank_shot_hears_noise_only():
    bench = Bench("thread")
    volts = bench.shot(field_t=0.0, rx=6100)[:, TX + SWITCH :]
    wanted = np.array([14e-3, 21e-3, 55e-3]) * np.diag(bench.calibration.sensitivity)
    assert volts.std(axis=1) == pytest.approx(wanted, rel=0.04)
    assert bench.truth()["phi_max_rad"] == 0.0


def test_nothing_mounted_is_a_quiet_platform():
    bench = Bench(None)
    volts = bench.shot(rx=610)
    assert np.abs(volts).max() < 0.3
    assert bench.truth()["variant"] is None


def test_same_seed_and_calls_give_the_same_bits_and_another_seed_does_not():
    def series(seed):
        bench = Bench("jewel", seed=seed)
        shots = [bench.shot(rx=2000, chunk=chunk) for chunk in (777, 100_000)]
        return np.concatenate(shots, axis=1), bench.truth()

    first, truth = series(7)
    again, truth_again = series(7)
    assert np.array_equal(first, again)
    assert truth == truth_again
    assert not np.array_equal(first, series(8)[0])


def test_polling_the_devices_does_not_change_the_physics():
    quiet, busy = Bench("jewel"), Bench("jewel")
    for _ in range(5):
        busy.thermometer.temperature_c()
        busy.amplifier.status()
        busy.backend.ground_truth()
    assert np.array_equal(quiet.shot(rx=1000), busy.shot(rx=1000))


def test_back_action_of_the_closed_loop_brakes_the_rotor_only_when_switched_on():
    free, braked = Bench("thread", **STEADY), Bench("thread", **STEADY, effects__back_action__enabled=True)
    for each in (free, braked):
        each.shot(rx=610)
    off, on = (b.truth()["amplitude_tx_end_rad"] for b in (free, braked))
    assert 1e-3 < 1 - on / off < 5e-3


def test_remounting_the_same_specimen_changes_nothing_and_another_starts_at_rest():
    bench = Bench("thread", **STEADY)
    bench.shot(rx=610)
    bench.backend.mount(specimen("thread"))
    assert bench.backend.world.unit.rotor_state.phi_rad != 0.0
    bench.backend.mount(specimen("jewel"))
    assert bench.backend.world.unit.rotor_state.phi_rad == 0.0


def test_a_world_that_has_shot_often_remembers_no_more_than_one_that_has_just_begun():
    """Its 20 000th shot must not take longer than its first."""
    bench, remembered = Bench("jewel", **QUIET), []
    for _ in range(12):
        bench.shot(rx=16)
        remembered.append(len(bench.backend.world.contacts().changes))
    assert remembered[-1] == remembered[2]
