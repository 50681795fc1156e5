"""Undeclared errors of the receive side: each against the clean shot of the same world and a formula."""

import numpy as np
import pytest

from sim_backend.rotor.rotor import effective
from tests.kit.simulated_bench import CLOCK, QUIET, SWITCH, TX, Bench, specimen

RX = TX + SWITCH
N = 12000
T = np.arange(N) / CLOCK.rate_hz


def received(*tables, variant="thread", rx=N, **changes):
    """RX window, (3, n) V, of the first shot of a quiet world with these effects."""
    return Bench(variant, **QUIET | changes, undeclared=list(tables)).shot(rx=rx)[:, RX:]


@pytest.fixture(scope="module")
def clean():
    return received()


@pytest.fixture(scope="module")
def per_am2():
    return np.abs(np.diag(Bench("thread").calibration.sensitivity))


STEP = 2.0**-22  # a few steps of the 24-bit card


def tone_at(signal, frequency_hz, first=0):
    """Complex amplitude of a line, by least squares with an offset."""
    t = T[: signal.size] + first / CLOCK.rate_hz
    columns = np.stack([np.cos(2 * np.pi * frequency_hz * t), np.sin(2 * np.pi * frequency_hz * t), np.ones(t.size)], 1)
    a, b, _ = np.linalg.lstsq(columns, signal, rcond=None)[0]
    return a - 1j * b


def test_channel_gain_scales_its_channel_only(clean):
    volts = received({"id": "channel_gain", "strength": 0.03, "axis": "x"})
    assert volts[0] == pytest.approx(1.03 * clean[0], abs=STEP)
    assert np.array_equal(volts[1:], clean[1:])


def test_channel_gain_of_a_band_scales_one_harmonic_only(clean):
    band = {"id": "channel_gain", "strength": 0.05, "frequency_hz": 430.0, "width_hz": 200.0}
    change = received(band) - clean
    u, v = (effective(specimen("thread")).rotation[:, k] for k in (0, 1))
    calibration = Bench("thread").calibration.sensitivity
    even, odd = (row @ np.linalg.solve(calibration, clean) for row in (u, v))
    at_u, at_v = (row @ np.linalg.solve(calibration, change) for row in (u, v))
    assert at_u == pytest.approx(0.05 * even, abs=0.05 * 0.02 * np.abs(even).max())
    assert np.abs(at_v).max() < 1e-4 * np.abs(odd).max()


def test_a_band_of_everything_is_a_gain(clean):
    band = {"id": "channel_gain", "strength": 0.05, "axis": "y", "frequency_hz": 100.0, "width_hz": 40e3}
    volts = received(band)
    assert volts[1] == pytest.approx(1.05 * clean[1], abs=1e-5 * np.abs(clean[1]).max())
    assert np.array_equal(volts[[0, 2]], clean[[0, 2]])


def test_crosstalk_adds_a_share_of_one_channel_to_another(clean):
    volts = received({"id": "crosstalk", "strength": -0.02, "from": "x", "to": "z"})
    assert volts[2] == pytest.approx(clean[2] - 0.02 * clean[0], abs=STEP)
    assert np.array_equal(volts[:2], clean[:2])


def test_channel_delay_is_the_signal_of_earlier(clean):
    volts = received({"id": "channel_delay", "strength": 3 / CLOCK.rate_hz, "axis": "x"})
    assert volts[0, 3:] == pytest.approx(clean[0, :-3], abs=STEP)
    assert np.array_equal(volts[1:], clean[1:])


def test_receive_lowpass_is_one_pole_that_the_calibration_does_not_know(clean):
    table = {"id": "receive_lowpass", "strength": 2e-5}
    volts = received(table)
    rate = np.gradient(volts[0], 1 / CLOCK.rate_hz)
    inner = slice(100, -100)
    assert (volts[0] + 2e-5 * rate)[inner] == pytest.approx(clean[0][inner], abs=3e-5 * np.abs(clean).max())
    assert Bench("thread", undeclared=[table]).calibration.frequency_response is None


def test_receiver_compression_is_its_formula(clean):
    volts = received({"id": "receiver_compression", "strength": 0.5, "axis": "x"})
    assert volts[0] == pytest.approx(clean[0] * (1 - 0.5 * clean[0] ** 2), abs=STEP)
    assert np.array_equal(volts[1:], clean[1:])
    top = received({"id": "receiver_compression", "strength": 50.0})
    assert np.abs(top).max() == pytest.approx(2 / 3 * 150.0**-0.5, rel=1e-3)


def test_lines_have_their_amplitude_and_run_on_in_world_time(per_am2):
    mains = {"id": "mains_interference", "strength": 0.02, "frequency_hz": 50, "harmonics": [1.0, 0.0, 0.5]}
    line = {"id": "spectral_line", "strength": 0.01, "frequency_hz": 333.0, "axis": "z"}
    bench, plain = (Bench("thread", **QUIET, undeclared=found) for found in ([mains, line], []))
    phases = []
    for _ in range(2):
        start_s = bench.clock.monotonic_s()
        change = bench.shot(rx=N)[:, RX:] - plain.shot(rx=N)[:, RX:]
        for f, levels in ((50.0, [0.02] * 3), (150.0, [0.01] * 3), (333.0, [0, 0, 0.01]), (100.0, [0] * 3)):
            others = sum((tones(change, g) for g in (50.0, 150.0, 333.0) if g != f), np.zeros_like(change))
            found = [abs(tone_at(row, f)) for row in change - others]
            assert found == pytest.approx(np.array(levels) * per_am2, rel=0.02, abs=2e-5)
        phases.append(np.angle(tone_at(change[2], 333.0)) - 2 * np.pi * 333.0 * (start_s + RX / CLOCK.rate_hz))
    assert np.exp(1j * phases[0]) == pytest.approx(np.exp(1j * phases[1]), abs=0.05)


def tones(rows, frequency_hz):
    return np.array([np.real(tone_at(r, frequency_hz) * np.exp(2j * np.pi * frequency_hz * T)) for r in rows])


def test_a_side_mode_starts_with_the_ring_down_and_decays(clean, per_am2):
    table = {"id": "side_mode", "strength": 0.3, "frequency_hz": 137.0, "tau_s": 0.05, "axis": "z", "phase_rad": 0.4}
    change = received(table) - clean
    wanted = 0.3 * per_am2[2] * np.exp(-T / 0.05) * np.cos(2 * np.pi * 137.0 * T + 0.4)
    assert change[2] == pytest.approx(wanted, abs=STEP)
    assert np.abs(change[:2]).max() == 0.0


def test_a_switch_transient_decays_from_its_height_at_the_first_sample(clean, per_am2):
    change = received({"id": "switch_transient", "strength": -0.5, "tau_s": 3e-3}) - clean
    assert change == pytest.approx(-0.5 * per_am2[:, None] * np.exp(-T / 3e-3), abs=STEP)


def test_after_a_clock_gap_the_samples_are_those_of_later_up_to_the_end():
    longer, gapped = received(rx=N + 7), received({"id": "clock_gap", "strength": 7, "sample": 5000})
    assert np.array_equal(gapped[:, :5000], longer[:, :5000])
    assert gapped[:, 5000:] == pytest.approx(longer[:, 5007 : N + 7], abs=STEP)


def test_the_card_does_not_notice_a_clock_gap():
    bench = Bench("thread", undeclared=[{"id": "clock_gap", "strength": 7, "sample": 500}])
    bench.start(bench.line_up(rx=2000))
    chunk = bench.card.read(10**6)
    assert (chunk.first_sample, chunk.volts.shape[1], chunk.flags.names()) == (0, RX + 2000, ())


@pytest.mark.parametrize(
    "table",
    [
        {"id": "channel_gain", "axis": "x"},
        {"id": "channel_delay"},
        {"id": "receiver_compression"},
        {"id": "crosstalk", "from": "x", "to": "y"},
        {"id": "spectral_line", "frequency_hz": 333.0},
        {"id": "side_mode", "frequency_hz": 333.0, "tau_s": 0.1, "axis": "x"},
        {"id": "switch_transient", "tau_s": 0.1},
    ],
)
def test_a_strength_of_zero_changes_no_bit(table, clean):
    assert np.array_equal(received({**table, "strength": 0.0}), clean)


def test_neither_calibration_nor_specimen_know_of_undeclared_effects():
    tables = [
        {"id": "channel_gain", "strength": 0.1, "axis": "x"},
        {"id": "crosstalk", "strength": 0.1, "from": "x", "to": "y"},
        {"id": "channel_delay", "strength": 1e-5},
    ]
    plain, other = Bench("thread"), Bench("thread", undeclared=tables)
    assert np.array_equal(plain.calibration.sensitivity, other.calibration.sensitivity)
    assert other.calibration.frequency_response is None
    other.shot(rx=100)
    assert [e["id"] for e in other.truth()["undeclared"]] == ["channel_gain", "crosstalk", "channel_delay"]
