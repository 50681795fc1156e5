"""What the boards play, computed from their programs, is what the timeline says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.errors import SequenceRejected
from drivers.red_pitaya.layout import BoardLayout, Layout, LinePin
from drivers.red_pitaya.sequence import HIGH_V, BoardProgram, compile_timeline
from drivers.timeline import Burst, DigitalLine, LineLevel, SampleClock, Timeline

CLOCK = SampleClock(125e6, 2048)
LAYOUT = Layout(
    boards=(BoardLayout((0, 1), (0, 1)), BoardLayout((0,), (0,))),
    lines={DigitalLine.PA_GATE: LinePin(0, "AO0"), DigitalLine.RX_CONNECT: LinePin(0, "AO1")},
    clock=CLOCK,
    step_samples=16,
    pin_delay_s=0.03,
)


def shot(*bursts: Burst, tx: int = 2880, lines: bool = True) -> Timeline:
    levels = (
        (LineLevel(DigitalLine.PA_GATE, 0, tx), LineLevel(DigitalLine.RX_CONNECT, tx + 64, tx + 4096)) if lines else ()
    )
    return Timeline(CLOCK, tx, 96, 4000, bursts, levels)


def played_v(program: BoardProgram, output: int, samples: int) -> np.ndarray:
    """What a board puts out on OUT1 or OUT2: a running sine, gated by the enable bits of each step."""
    k = np.arange(samples)
    step = k // program.step_samples
    inside = step < len(program.enable)
    gate = np.where(inside, program.enable[np.minimum(step, len(program.enable) - 1), output], 0)
    sines = [s for s in program.sines if s.output == output]
    return gate * sum(
        s.amplitude_v * np.sin(2 * np.pi * s.frequency_hz * k / CLOCK.rate_hz + s.phase_rad) for s in sines
    )


@given(
    start=st.integers(0, 100),
    length=st.integers(1, 80),
    frequency_hz=st.floats(1.0, 7000.0),
    amplitude_v=st.floats(-1.0, 1.0).filter(lambda a: abs(a) > 1e-3),
    phase_rad=st.floats(-10.0, 10.0),
    output=st.integers(0, 2),
)
def test_a_burst_is_played_to_the_sample(start, length, frequency_hz, amplitude_v, phase_rad, output):
    burst = Burst(output, 16 * start, 16 * (start + length), frequency_hz, amplitude_v, phase_rad)
    timeline = shot(burst)
    programs = compile_timeline(timeline, LAYOUT)
    board, out = LAYOUT.output(output)
    n = timeline.total_samples
    assert np.allclose(played_v(programs[board], out, n), timeline.output_volts(output, 0, n), rtol=0, atol=1e-6)


def test_lines_go_high_and_low_at_their_samples_and_only_there():
    timeline = shot(Burst(0, 0, 2880, 211.9, 0.2))
    program = compile_timeline(timeline, LAYOUT)[0]
    levels = np.repeat(program.levels_v, program.step_samples, axis=0)
    for channel, line in ((2, DigitalLine.PA_GATE), (3, DigitalLine.RX_CONNECT)):
        high = [timeline.is_high(line, k) for k in range(timeline.total_samples)]
        assert np.array_equal(levels[: len(high), channel] == np.float32(HIGH_V), high)
        assert not levels[len(high) :, channel].any()


def test_a_sequence_outlasts_its_last_edge_by_a_silent_step_and_then_ends():
    timeline = shot(Burst(0, 0, 2880, 211.9, 0.2))
    for program in compile_timeline(timeline, LAYOUT):
        assert not program.levels_v[-1].any()
        assert not program.enable[-1, :2].any()
        assert program.samples <= timeline.total_samples + 128


def test_a_train_of_bursts_of_one_running_sine_is_played():
    f = 20 * CLOCK.rate_hz / 2880
    bursts = [Burst(1, k, k + 320, f, 0.3, 2 * np.pi * f * k / CLOCK.rate_hz) for k in (0, 640, 1600)]
    timeline = shot(*bursts)
    n = timeline.total_samples
    found = played_v(compile_timeline(timeline, LAYOUT)[0], 1, n)
    assert np.allclose(found, timeline.output_volts(1, 0, n), rtol=0, atol=1e-6)


def test_three_sines_at_once_are_played_and_four_are_not():
    three = [Burst(0, 0, 2880, 200.0 + k, 0.1, k) for k in range(3)]
    n = shot().total_samples
    found = played_v(compile_timeline(shot(*three), LAYOUT)[0], 0, n)
    assert np.allclose(found, shot(*three).output_volts(0, 0, n), rtol=0, atol=1e-6)
    with pytest.raises(SequenceRejected, match="3 sines, not 4"):
        compile_timeline(shot(*three, Burst(0, 0, 2880, 300.0, 0.1)), LAYOUT)


@pytest.mark.parametrize(
    ("timeline", "complaint"),
    [
        (shot(Burst(0, 0, 2879, 212.0, 0.2)), "multiples of 16"),
        (shot(Burst(0, 8, 2880, 212.0, 0.2)), "multiples of 16"),
        (shot(Burst(3, 0, 2880, 212.0, 0.2)), "no output 3"),
        (shot(Burst(0, 0, 2880, 212.0, 1.2)), "1.2 V of"),
        (shot(Burst(0, 0, 2880, 212.0, 0.6), Burst(0, 0, 2880, 300.0, 0.6)), "1.2 V of"),
        (shot(Burst(0, 0, 2880, 40e3, 0.2)), "outside"),
        (shot(Burst(0, 0, 1600, 212.0, 0.2), Burst(0, 800, 2880, 212.0, 0.2)), "overlap"),
        (shot(Burst(0, 0, 800, 212.0, 0.2), Burst(0, 1600, 2880, 300.0, 0.2)), "one running sine"),
        (shot(Burst(0, 0, 800, 212.0, 0.2), Burst(0, 1600, 2880, 212.0, 0.2)), "one running sine"),
        (replace(shot(), clock=SampleClock(125e6, 1024)), "clock"),
    ],
)
def test_what_cannot_be_played_exactly_is_refused_and_named(timeline, complaint):
    with pytest.raises(SequenceRejected, match=complaint):
        compile_timeline(timeline, LAYOUT)


def test_lines_on_dio_pins_need_time_between_gate_and_receiver():
    pins = {DigitalLine.PA_GATE: LinePin(0, "DIO7_P"), DigitalLine.RX_CONNECT: LinePin(0, "DIO6_P")}
    on_pins = replace(LAYOUT, lines=pins)
    with pytest.raises(SequenceRejected, match="DIO pins"):
        compile_timeline(shot(Burst(0, 0, 2880, 212.0, 0.2)), on_pins)
    apart = (LineLevel(DigitalLine.PA_GATE, 0, 2880), LineLevel(DigitalLine.RX_CONNECT, 5000, 8000))
    far = Timeline(CLOCK, 2880, 4000, 2000, (Burst(0, 0, 2880, 212.0, 0.2),), apart)
    assert compile_timeline(far, on_pins)


@pytest.mark.parametrize(
    ("gate", "receiver", "outputs", "channels"),
    [
        (LinePin(0, "AO0"), LinePin(0, "AO1"), (0,), (4, 1)),
        (LinePin(0, "AO0"), LinePin(1, "AO0"), (0, 1, 2), (3, 3)),
        (LinePin(0, "DIO7_P"), LinePin(0, "DIO6_P"), (0, 1, 2), (2, 1)),
        (LinePin(0, "DIO7_P"), LinePin(0, "DIO6_P"), (0,), (1, 1)),
    ],
)
def test_a_sequence_has_the_channels_up_to_the_last_one_it_needs(gate, receiver, outputs, channels):
    """Each costs the server time, of every shot."""
    layout = replace(LAYOUT, lines={DigitalLine.PA_GATE: gate, DigitalLine.RX_CONNECT: receiver})
    apart = (LineLevel(DigitalLine.PA_GATE, 0, 2880), LineLevel(DigitalLine.RX_CONNECT, 8000, 9600))
    bursts = tuple(Burst(k, 0, 2880, 212.0, 0.2) for k in outputs)
    programs = compile_timeline(Timeline(CLOCK, 2880, 5120, 1600, bursts, apart), layout)
    assert tuple(p.levels_v.shape[1] for p in programs) == channels


def test_levels_are_held_by_the_sequence_and_leave_the_sines_out():
    volts = [0.1, -0.2, 0.3, 0.05]
    levels = [Burst(0, 160 * k, 160 * (k + 1), 0.0, v, np.pi / 2) for k, v in enumerate(volts)]
    programs = compile_timeline(shot(*levels, Burst(1, 0, 2880, 212.0, 0.2)), LAYOUT)
    program = programs[0]
    step = program.step_samples
    for k, v in enumerate(volts):
        held = program.levels_v[160 * k // step : 160 * (k + 1) // step, 0]
        assert np.allclose(held, v)
    assert not np.any(program.levels_v[640 // step :, 0])
    assert [sine.output for sine in program.sines] == [1]


@pytest.mark.parametrize(
    ("bursts", "word"),
    [
        ((Burst(0, 0, 160, 0.0, 1.2, np.pi / 2),), "1.2 V of"),
        ((Burst(0, 0, 160, 0.0, 0.2, np.pi / 2), Burst(0, 0, 160, 0.0, 0.3, np.pi / 2)), "one level at a time"),
        ((Burst(0, 0, 160, 0.0, 0.2, np.pi / 2), Burst(0, 80, 240, 0.0, 0.3, np.pi / 2)), "overlap"),
        ((Burst(0, 0, 160, 0.0, 0.2, np.pi / 2), Burst(0, 160, 320, 212.0, 0.3)), "outside"),
    ],
)
def test_levels_that_cannot_be_held_are_refused(bursts, word):
    with pytest.raises(SequenceRejected) as caught:
        compile_timeline(shot(*bursts), LAYOUT)
    assert word in (caught.value.why or "")
