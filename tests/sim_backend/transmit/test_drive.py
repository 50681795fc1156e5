from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drivers.timeline import Burst, DigitalLine, LineLevel, Timeline
from drivers.tx_rx_switch import SwitchPosition
from sim_backend.options import CoilOptions
from sim_backend.transmit.drive import AmplifierChannel, cuts, high_intervals
from tests.kit.simulated_bench import CLOCK, QUIET, TX, Bench, options

COIL = CoilOptions.model_validate(options()["coils"]["x"])
OHM, HENRY = COIL.resistance_ohm + 0.1, COIL.inductance_h
ON = SwitchPosition.TRANSMIT
RATE = CLOCK.rate_hz


def current(stages, times):
    out = np.zeros(times.size)
    for cut in stages:
        inside = (times >= cut.start_s) & (times < cut.stop_s)
        out[inside] = cut.current_a(0, times[inside])
    return out


def one(bursts, live, spans=((0.0, 0.1, ON),), limit_v=9.0):
    channel = AmplifierChannel(bursts=tuple(bursts), rate_hz=RATE, gain=10.0, limit_v=limit_v)
    return cuts([channel], live, list(spans), [COIL], 0.1)


def reference(volts, stop, times):
    r = solve_ivp(lambda t, i: (volts(t) - OHM * i) / HENRY, (0, stop), [0.0], "DOP853", t_eval=times,
                  rtol=1e-10, atol=1e-14, max_step=2e-5)  # fmt: skip
    return r.y[0]


def test_current_of_a_gated_sine_solves_the_loop_equation_transient_included():
    burst = Burst(0, 100, 2000, 212.0, 0.3, 0.7)
    start, stop = 100 / RATE, 2000 / RATE

    def volts(t):
        return 3.0 * np.sin(2 * np.pi * 212 * (t - start) + 0.7) if start <= t < stop else 0.0

    times = np.linspace(0, 0.05, 400, endpoint=False)
    ours = current(one([burst], [(0.0, 0.1)]), times)
    assert ours == pytest.approx(reference(volts, 0.05, times), abs=1e-6)


def test_clipped_current_solves_the_loop_equation_with_the_clipped_voltage():
    burst = Burst(0, 0, 2000, 212.0, 0.5)
    stages = one([burst], [(0.0, 0.1)], limit_v=2.0)
    times = np.linspace(0, 0.03, 300, endpoint=False)
    wanted = reference(lambda t: np.clip(5 * np.sin(2 * np.pi * 212 * t), -2, 2), 0.03, times)
    assert current(stages, times) == pytest.approx(wanted, abs=1e-6)
    assert any(c.clipped for c in stages)


def test_precompensated_burst_gives_a_pure_sine_from_the_first_instant_and_ends_at_zero_current():
    bench = Bench("thread", **QUIET)
    burst = bench.line_up(215e-6).bursts[0]
    stages = one([burst], [(0.0, 0.1)])
    times = np.arange(TX) / RATE
    b = bench.channels[0].field_per_ampere_t[0]
    wanted = 215e-6 * np.sin(2 * np.pi * burst.frequency_hz * times)
    assert b * current(stages, times) == pytest.approx(wanted, abs=1e-15)
    later = TX / RATE + np.linspace(1e-6, 1e-2, 50)
    assert np.abs(current(stages, later)).max() < 1e-13


def test_gate_off_lets_the_current_die_with_l_over_r():
    burst = Burst(0, 0, 6000, 212.0, 0.3)
    off = 0.0212
    stages = one([burst], [(0.0, off)])
    at, later = current(stages, np.array([off, off + HENRY / OHM]))
    assert abs(at) > 0.1
    assert later / at == pytest.approx(np.exp(-1), rel=1e-12)


def test_open_contacts_interrupt_the_current_at_once():
    burst = Burst(0, 0, 6000, 212.0, 0.3)
    spans = [(0.0, 0.02, ON), (0.02, 0.023, SwitchPosition.MOVING), (0.023, 0.1, SwitchPosition.RECEIVE)]
    stages = one([burst], [(0.0, 0.1)], spans)
    assert np.abs(current(stages, np.linspace(0.02, 0.09, 100))).max() == 0.0
    assert np.abs(current(stages, np.linspace(0.01, 0.0199, 100))).max() > 0.1


def test_cuts_cover_time_without_gaps():
    stages = one([Burst(0, 10, 2000, 212.0, 0.5), Burst(0, 500, 900, 1000.0, 0.2)], [(0.001, 0.02)], limit_v=2.0)
    assert stages[0].start_s == 0.0
    assert stages[-1].stop_s == 0.1
    assert all(a.stop_s == b.start_s for a, b in pairwise(stages))


def test_overlapping_gates_are_joined():
    lines = tuple(LineLevel(DigitalLine.PA_GATE, a, b) for a, b in ((100, 200), (0, 50), (150, 300)))
    line_up = Timeline(CLOCK, 100, 100, 200, (), lines)
    assert high_intervals(line_up, DigitalLine.PA_GATE) == [(0.0, 50 / RATE), (100 / RATE, 300 / RATE)]


def test_too_much_drive_clips_and_the_amplifier_says_so_until_enabled_again():
    bench = Bench("thread", **QUIET, amplifier__limit_v=0.9)
    bench.shot(rx=610)
    assert bench.amplifier.status().clipped
    bench.amplifier.enable()
    assert not bench.amplifier.status().clipped


def test_no_current_without_gate_or_with_a_muted_amplifier():
    bench = Bench("thread", **QUIET)
    open_gate = bench.line_up(rx=610)
    bench.shot(rx=610, lines=tuple(x for x in open_gate.lines if x.line is not DigitalLine.PA_GATE))
    assert bench.truth()["peak_current_a"] == [0.0, 0.0, 0.0]
    bench.card.program(open_gate)
    bench.card.arm()
    bench.card.trigger()
    bench.card.read(10**6)
    assert bench.truth()["peak_current_a"] == [0.0, 0.0, 0.0]
