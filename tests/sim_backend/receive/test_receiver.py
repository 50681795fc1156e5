import numpy as np
import pytest

from drivers.timeline import DigitalLine, LineLevel
from sim_backend.receive.receiver import digitised
from sim_backend.rotor.rotor import effective
from sim_backend.rotor.trajectory import states
from tests.kit.simulated_bench import CLOCK, QUIET, SWITCH, TX, Bench, specimen

RX = TX + SWITCH
PAPER = np.array([14e-3, 21e-3, 55e-3])


def spectrum(values):
    return np.fft.rfftfreq(values.shape[1], 1 / CLOCK.rate_hz), np.abs(np.fft.rfft(values, axis=1)) ** 2


def blank(**changes):
    """dm/dt of a blank shot, RX window, (3, n) A m^2/s."""
    bench = Bench("thread", **changes)
    return -np.linalg.solve(bench.calibration.sensitivity, bench.shot(field_t=0.0, rx=61035)[:, RX:])


def test_noise_has_the_papers_level_in_every_channel_and_the_truth_states_it():
    assert blank().std(axis=1) == pytest.approx(PAPER, rel=0.01)
    bench = Bench("thread")
    bench.shot(rx=100)
    assert bench.truth()["noise_sd_am2_per_s"] == pytest.approx(PAPER, rel=1e-3)


def test_noise_is_white_by_default_and_independent_between_channels():
    noise = blank()
    f, power = spectrum(noise)
    for row in power:
        low, high = row[(f > 100) & (f < 5000)].mean(), row[f > 20000].mean()
        assert low / high == pytest.approx(1.0, abs=0.1)
    assert np.abs(np.corrcoef(noise) - np.eye(3)).max() < 0.02


def test_coloured_noise_rises_at_low_frequency_and_keeps_its_rms():
    noise = blank(noise__colour__enabled=True, noise__colour__corner_hz=[0.0, 0.0, 1000.0])
    assert noise.std(axis=1) == pytest.approx(PAPER, rel=0.15)
    f, power = spectrum(noise)
    ratio = [row[(f > 50) & (f < 150)].mean() / row[f > 20000].mean() for row in power]
    assert ratio[0] == pytest.approx(1, abs=0.4)
    assert ratio[2] == pytest.approx(1 + 1000 / 100, rel=0.4)


def test_hum_stands_at_its_frequencies_with_its_amplitudes_and_runs_on_in_world_time():
    levels = [[0.02, 0.0, 0.1], [0.0, 0.05, 0.0]]
    signal = blank(noise__hum__enabled=True, noise__hum__amplitude_am2_per_s=levels)
    t = np.arange(signal.shape[1]) / CLOCK.rate_hz
    tones = np.concatenate([[np.cos(2 * np.pi * f * t), np.sin(2 * np.pi * f * t)] for f in (50.0, 100.0)]).T
    found = np.linalg.lstsq(tones, signal.T, rcond=None)[0]
    assert np.hypot(found[0], found[1]) == pytest.approx(levels[0], abs=1.5e-3)
    assert np.hypot(found[2], found[3]) == pytest.approx(levels[1], abs=1.5e-3)


def test_volts_are_minus_p_times_dm_dt_at_the_sample_instants():
    bench = Bench("jewel", **QUIET)
    volts = bench.shot(rx=6000)
    _, result = bench.backend.world.shot_simulator.result()
    phi, phi_dot = states(result.pieces, np.arange(RX, RX + 6000) / CLOCK.rate_hz)
    rotor = effective(specimen("jewel"))
    local = rotor.m_r_am2 * phi_dot * np.stack([-np.sin(phi), np.cos(phi)])
    wanted = -bench.calibration.sensitivity @ rotor.rotation[:, :2] @ local
    assert np.abs(volts[:, RX:] - wanted).max() < 1.01 * 2.0**-24  # half a step of 24 bit
    assert bench.truth()["phi_rad"] == pytest.approx(phi[0])
    assert bench.truth()["phi_dot_rad_per_s"] == pytest.approx(phi_dot[0])


def test_adc_gives_multiples_of_its_step_and_clips_at_its_codes():
    step = 2.0**-15
    volts = digitised(np.array([[0.4 * step, 0.6 * step, -2.0, 2.0, 1.0]]), step, 16)
    assert volts.dtype == np.float32
    assert (volts[0] / step).tolist() == [0, 1, -32768, 32767, 32767]
    codes = Bench("thread").shot(rx=600) / step
    assert np.array_equal(codes, np.rint(codes))


def test_a_gain_too_high_clips_and_reports_overload():
    bench = Bench("jewel")
    bench.lna.set_gain(100.0)
    volts = bench.shot(rx=6000)[:, RX:]
    assert volts.max() == pytest.approx(1 - 2.0**-15)
    assert volts.min() == -1.0
    assert bench.lna.overloaded()
    bench.lna.clear_overload()
    assert not bench.lna.overloaded()


def test_signal_follows_the_lna_gain():
    levels = []
    for gain in (10.0, 40.0):
        bench = Bench("thread", **QUIET)
        bench.lna.set_gain(gain)
        levels.append(bench.shot(rx=600)[0, RX:].std())
    assert levels[1] / levels[0] == pytest.approx(4.0, rel=1e-4)


def test_receiver_hears_only_the_leak_while_transmitting():
    bench = Bench("thread", **QUIET)
    tx = bench.shot(rx=600)[:, :TX]
    drive = bench.channels[0].amplifier_gain * bench.line_up().output_volts(0, 0, TX)
    assert tx[0] == pytest.approx(40 * 1e-4 * drive, abs=1e-6)
    assert np.abs(tx[1:]).max() == 0.0
    tighter = Bench("thread", **QUIET, switch__isolation_db=100.0).shot(rx=600)[:, :TX]
    assert tighter.std() / tx.std() == pytest.approx(0.1, rel=1e-3)


def test_dead_time_is_silent_then_contacts_bounce_then_the_transient_dies_within_the_stated_time():
    bench = Bench("thread", **QUIET | {"switch__transient_v": [0.2, 0.2, 0.1]})
    volts = bench.shot(field_t=0.0, rx=600)
    timing = bench.switch.timing()
    command = (TX + 30) / CLOCK.rate_hz
    dead, good = (int((command + s) * CLOCK.rate_hz) for s in (timing.dead_time_s, timing.total_s))
    assert np.abs(volts[:, TX : dead - 1]).max() == 0.0
    assert np.abs(volts[:, dead : dead + 100]).max(axis=1) == pytest.approx([0.2, 0.2, 0.1], rel=0.1)
    assert np.abs(volts[:, good:]).max() < 1e-6
    assert timing.total_s == pytest.approx(8e-3)
    assert good < RX


def test_bouncing_contacts_interrupt_the_signal():
    bench = Bench("thread", **QUIET)
    volts = bench.shot(rx=600)
    start = int((TX + 30) / 1 + 3e-3 * CLOCK.rate_hz)
    chatter = volts[:, start + 1 : start + 62]
    gaps = np.count_nonzero(np.all(chatter == 0.0, axis=0))
    assert 3 < gaps < 58


def test_non_ideal_chain_lowers_and_delays_the_signal_as_its_calibration_says():
    ideal, real = Bench("thread", **QUIET), Bench("thread", **QUIET, receive__chain="non_ideal")
    assert ideal.calibration.frequency_response is None
    a, b = (x.shot(rx=12000)[0, RX:] for x in (ideal, real))
    spectra = [np.fft.rfft(x * np.hanning(x.size)) for x in (a, b)]
    k = int(np.argmax(np.abs(spectra[0])))
    f = np.fft.rfftfreq(a.size, 1 / CLOCK.rate_hz)[k]
    declared = np.interp(f, real.calibration.frequency_hz, real.calibration.frequency_response[0])
    assert spectra[1][k] / spectra[0][k] == pytest.approx(declared, abs=2e-4)
    assert abs(declared - 1) > 5e-3


def test_lines_may_reconnect_and_disconnect_within_a_shot():
    bench = Bench("thread", **QUIET)
    lines = (
        LineLevel(DigitalLine.PA_GATE, 0, TX),
        LineLevel(DigitalLine.RX_CONNECT, TX + 30, RX + 3000),
        LineLevel(DigitalLine.RX_CONNECT, RX + 6000, RX + 12207),
    )
    volts = bench.shot(lines=lines)
    assert np.abs(volts[0, RX : RX + 3000]).max() > 0.1
    assert np.abs(volts[0, RX + 3001 : RX + 6180]).max() == 0.0
    assert np.abs(volts[0, RX + 6300 :]).max() > 0.1
