import numpy as np
import pytest

from drivers.timeline import Burst, DigitalLine, LineLevel, SampleClock, Timeline

CLOCK = SampleClock(125e6, 2048)


def test_the_papers_card_samples_at_61_khz():
    assert CLOCK.rate_hz == pytest.approx(61035.15625)


def test_a_burst_is_zero_outside_its_samples_and_starts_with_its_phase():
    timeline = Timeline(CLOCK, 100, 10, 50, bursts=(Burst(1, 20, 80, 1000.0, 0.5, np.pi / 2),))
    volts = timeline.output_volts(1, 0, timeline.total_samples)
    assert volts[19] == volts[80] == 0
    assert volts[20] == 0.5
    assert not np.any(timeline.output_volts(0, 0, 100))


def test_a_line_is_low_wherever_nothing_raises_it():
    timeline = Timeline(CLOCK, 100, 10, 50, lines=(LineLevel(DigitalLine.PA_GATE, 0, 100),))
    assert timeline.is_high(DigitalLine.PA_GATE, 99)
    assert not timeline.is_high(DigitalLine.PA_GATE, 100)
    assert not timeline.is_high(DigitalLine.RX_CONNECT, 50)


@pytest.mark.parametrize(
    "parts",
    [
        {"bursts": (Burst(0, 0, 161, 1.0, 1.0),)},
        {"bursts": (Burst(0, 5, 5, 1.0, 1.0),)},
        {"lines": (LineLevel(DigitalLine.PA_GATE, -1, 5),)},
    ],
)
def test_parts_outside_the_frame_are_refused(parts):
    with pytest.raises(ValueError, match="outside"):
        Timeline(CLOCK, 100, 10, 50, **parts)


def test_a_timeline_without_rx_samples_is_refused():
    with pytest.raises(ValueError, match="rx"):
        Timeline(CLOCK, 100, 10, 0)
