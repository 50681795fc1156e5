"""What the devices of a platform must do together."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from drivers.conformance.timelines import short_shot
from drivers.io_card import CardState
from drivers.platform import Platform
from drivers.timeline import Timeline
from drivers.tx_rx_switch import SwitchPosition


class PlatformContract:
    """Offer the fixture `platform`."""

    @pytest.fixture(autouse=True)
    def _off(self, platform: Platform) -> Iterator[None]:
        platform.outputs_off()
        yield
        platform.outputs_off()

    def _run_to(self, platform: Platform, timeline: Timeline, sample: int, done: int = 0) -> int:
        """Read until so many samples have come."""
        while done < sample:
            done += platform.card.read(sample - done).volts.shape[1]
        return done

    def test_outputs_off_can_always_be_said(self, platform: Platform) -> None:
        """And leaves nothing on."""
        for _ in range(2):
            platform.outputs_off()
            self.assert_off(platform)

    def test_the_switch_follows_its_line_through_a_shot_and_comes_home(self, platform: Platform) -> None:
        """The amplifier stays disabled all the time."""
        timeline = short_shot(platform.card.capabilities(), rx_s=1.0)
        platform.card.program(timeline)
        assert platform.switch.position() is SwitchPosition.TRANSMIT
        platform.card.arm()
        platform.card.trigger()
        done = self._run_to(platform, timeline, timeline.rx_start + 1)
        assert platform.switch.position() is SwitchPosition.RECEIVE
        self._run_to(platform, timeline, timeline.total_samples, done)
        platform.outputs_off()
        self.assert_off(platform)

    def test_a_stop_in_the_middle_of_a_shot_leaves_nothing_on(self, platform: Platform) -> None:
        """Receiver connected, amplifier enabled and unmuted with its gate low."""
        timeline = short_shot(platform.card.capabilities(), bursts=False, rx_s=1.0)
        platform.card.program(timeline)
        platform.card.arm()
        platform.amplifier.enable()
        platform.card.trigger()
        self._run_to(platform, timeline, timeline.rx_start + 1)
        platform.outputs_off()
        self.assert_off(platform)

    @staticmethod
    def assert_off(platform: Platform) -> None:
        """Card idle, amplifier disabled and muted, receiver disconnected."""
        assert platform.card.state() is CardState.IDLE
        status = platform.amplifier.status()
        assert not status.enabled
        assert status.muted
        assert platform.switch.position() is SwitchPosition.TRANSMIT
