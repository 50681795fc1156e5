"""What every I/O card must do."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from drivers.conformance.incidents import IncidentContract
from drivers.conformance.repeatability import RepeatabilityContract
from drivers.conformance.timelines import collect, short_shot
from drivers.errors import DeviceStateError, InputError, SequenceRejected
from drivers.io_card import CardState, IoCard
from drivers.platform import Platform
from drivers.timeline import Burst, SampleClock, Timeline

WAKE_UP_S = 5.0


class CardContract(RepeatabilityContract, IncidentContract):
    """Offer the fixture `card` or `platform`, and `abandon`, `emergency` and `stranger` if there is a way."""

    @pytest.fixture(scope="class")
    @classmethod
    def card(cls, platform: Platform) -> IoCard:
        """The card under test, IDLE."""
        return platform.card

    @pytest.fixture(autouse=True)
    def _idle(self, card: IoCard) -> Iterator[None]:
        """Before and after every test."""
        card.stop()
        yield
        card.stop()

    def test_it_says_who_it_is(self, card: IoCard) -> None:
        """Manufacturer or model at least."""
        assert card.identity().manufacturer or card.identity().model
        assert card.identity() == card.identity()

    def test_its_capabilities_are_constant_and_positive(self, card: IoCard) -> None:
        """Every number means something."""
        can = card.capabilities()
        assert can == card.capabilities()
        assert min(can.inputs, can.outputs, can.max_samples, can.step_samples) >= 1
        assert min(can.input_full_scale_v, can.output_full_scale_v, can.clock.rate_hz) > 0
        assert min(can.line_delay_s, can.output_step_v, can.frequency_step_hz) >= 0

    def test_a_shot_walks_through_the_states_in_order(self, card: IoCard) -> None:
        """Idle, programmed, armed, running, idle."""
        timeline = short_shot(card.capabilities())
        assert card.state() is CardState.IDLE
        card.program(timeline)
        assert card.state() is CardState.PROGRAMMED
        card.arm()
        assert card.state() is CardState.ARMED
        card.trigger()
        assert card.state() is CardState.RUNNING
        left = timeline.total_samples
        while left:
            assert card.state() is CardState.RUNNING
            left -= card.read(left).volts.shape[1]
        assert card.state() is CardState.IDLE

    @pytest.mark.parametrize("most", [997, 1_000_000])
    def test_every_sample_comes_once_and_in_order(self, card: IoCard, most: int) -> None:
        """Whatever the size of the reads."""
        timeline = short_shot(card.capabilities())
        inputs = card.capabilities().inputs
        done = 0
        for chunk in collect(card, timeline, most):
            assert chunk.first_sample == done
            assert chunk.volts.dtype == np.float32
            assert chunk.volts.shape[0] == inputs
            assert 1 <= chunk.volts.shape[1] <= most
            assert np.all(np.isfinite(chunk.volts))
            assert not chunk.flags.names()
            done += chunk.volts.shape[1]
        assert done == timeline.total_samples

    def test_it_tells_the_sample_that_is_being_taken(self, card: IoCard) -> None:
        """By its own clock, and only while it runs."""
        timeline = short_shot(card.capabilities(), rx_s=0.5)
        assert card.sample() is None
        card.program(timeline)
        card.arm()
        assert card.sample() is None
        card.trigger()
        for wanted in (1000, 5000):
            while (left := wanted - (card.sample() or 0)) > 0:
                card.read(left)
            assert card.state() is CardState.RUNNING
        card.stop()
        assert card.sample() is None

    def test_shot_follows_shot(self, card: IoCard) -> None:
        """The same timeline, another one, and the first again; each must be programmed again."""
        long, short = short_shot(card.capabilities()), short_shot(card.capabilities(), bursts=False, rx_s=0.03)
        for timeline in (long, long, short, long):
            assert sum(c.volts.shape[1] for c in collect(card, timeline, 5000)) == timeline.total_samples
            with pytest.raises(DeviceStateError):
                card.arm()

    def test_a_timeline_can_be_replaced_before_it_is_armed(self, card: IoCard) -> None:
        """The last one counts."""
        card.program(short_shot(card.capabilities()))
        short = short_shot(card.capabilities(), rx_s=0.03)
        assert sum(c.volts.shape[1] for c in collect(card, short, 5000)) == short.total_samples

    def test_steps_out_of_order_are_refused(self, card: IoCard) -> None:
        """And change nothing."""
        timeline = short_shot(card.capabilities())
        for step in (card.arm, card.trigger, lambda: card.read(1)):
            with pytest.raises(DeviceStateError):
                step()
        card.program(timeline)
        for step in (card.trigger, lambda: card.read(1)):
            with pytest.raises(DeviceStateError):
                step()
        card.arm()
        for step in (card.arm, lambda: card.program(timeline), lambda: card.read(1)):
            with pytest.raises(DeviceStateError):
                step()
        assert card.state() is CardState.ARMED

    def test_a_read_of_no_samples_is_refused(self, card: IoCard) -> None:
        """It could never make progress."""
        with pytest.raises(InputError):
            card.read(0)

    def test_what_it_cannot_play_exactly_is_refused(self, card: IoCard) -> None:
        """Never clamped, never rounded; the card stays idle."""
        can = card.capabilities()
        good = short_shot(can)
        end = good.tx_samples
        f = 10 * can.clock.rate_hz / good.tx_samples

        def with_burst(output: int = 0, start: int = 0, hz: float = f, volts: float = 0.0) -> Timeline:
            """`good` with another burst; volts 0: a thousandth of full scale."""
            return replace(good, bursts=(Burst(output, start, end, hz, volts or 1e-3 * can.output_full_scale_v),))

        wrong = [
            replace(good, clock=SampleClock(can.clock.base_frequency_hz, 2 * can.clock.decimation)),
            replace(good, rx_samples=good.rx_samples + can.max_samples),
            with_burst(output=can.outputs),
            with_burst(output=-1),
            with_burst(volts=1.5 * can.output_full_scale_v),
            with_burst(hz=0.75 * can.clock.rate_hz),
        ]
        if not can.holds_levels:
            wrong.append(with_burst(hz=0.0))
        if can.step_samples > 1:
            wrong.append(with_burst(start=can.step_samples // 2))
        for timeline in wrong:
            with pytest.raises(SequenceRejected):
                card.program(timeline)
            assert card.state() is CardState.IDLE

    @pytest.mark.parametrize("state", list(CardState)[:4])
    def test_stop_makes_it_idle_from_every_state(self, card: IoCard, state: CardState) -> None:
        """And the next shot is whole."""
        timeline = short_shot(card.capabilities())
        steps = [lambda: card.program(timeline), card.arm, card.trigger]
        for step in steps[: list(CardState).index(state)]:
            step()
        assert card.state() is state
        card.stop()
        card.stop()
        assert card.state() is CardState.IDLE
        with pytest.raises(DeviceStateError):
            card.read(1)
        assert sum(c.volts.shape[1] for c in collect(card, timeline, 5000)) == timeline.total_samples

    def test_stop_from_another_thread_wakes_whoever_reads(self, card: IoCard) -> None:
        """With DeviceStateError, also in the middle of a shot."""
        timeline = short_shot(card.capabilities(), rx_s=2.0)
        outcome: list[BaseException] = []
        begun = threading.Event()

        def read() -> None:
            """To the end of the shot, or of the patience."""
            try:
                while True:
                    card.read(1000)
                    begun.set()
            except BaseException as error:
                outcome.append(error)

        card.program(timeline)
        card.arm()
        card.trigger()
        reader = threading.Thread(target=read)
        reader.start()
        assert begun.wait(WAKE_UP_S)
        card.stop()
        reader.join(WAKE_UP_S)
        assert not reader.is_alive()
        assert [type(error) for error in outcome] == [DeviceStateError]

    def test_volts_are_inside_the_full_scale(self, card: IoCard) -> None:
        """The scale of the samples is that of the capabilities."""
        can = card.capabilities()
        highest = max(float(np.max(np.abs(c.volts))) for c in collect(card, short_shot(can), 5000))
        assert highest <= 1.01 * can.input_full_scale_v
