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


def test_a_burst_of_frequency_zero_is_a_level_and_the_loudest_sum_counts_what_sounds_together():
    bursts = (Burst(0, 0, 50, 0.0, -0.4, np.pi / 2), Burst(0, 50, 90, 1000.0, 0.7), Burst(0, 80, 95, 500.0, 0.2))
    timeline = Timeline(CLOCK, 100, 10, 50, bursts=bursts)
    assert np.all(timeline.output_volts(0, 0, 50) == -0.4)
    assert timeline.loudest_v(0) == pytest.approx(0.9)
    assert timeline.loudest_v(1) == 0.0
    fine = timeline.output_volts(0, 45, 100, per_sample=4)
    assert fine.shape == (220,)
    assert np.allclose(fine[::4], timeline.output_volts(0, 45, 100))
