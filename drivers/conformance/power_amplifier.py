"""What every power amplifier must do.  The card's gate line is low all the time: no power reaches the coils."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import pytest

from drivers.errors import DeviceFault, DeviceStateError
from drivers.platform import Platform
from drivers.power_amplifier import PowerAmplifier


class AmplifierContract:
    """Offer the fixture `amplifier` or `platform`, and `trip` if there is a way to make the amplifier latch a fault."""

    @pytest.fixture(scope="class")
    @classmethod
    def amplifier(cls, platform: Platform) -> PowerAmplifier:
        """The amplifier under test."""
        return platform.amplifier

    @pytest.fixture
    def trip(self) -> Callable[[], None]:
        """Makes the amplifier latch a fault whose cause vanishes at once."""
        pytest.skip("nothing here can trip the amplifier")

    @pytest.fixture(autouse=True)
    def _off(self, amplifier: PowerAmplifier) -> Iterator[None]:
        yield
        amplifier.disable()

    def test_it_starts_disabled_and_muted(self, amplifier: PowerAmplifier) -> None:
        """So it must be the first test that runs."""
        status = amplifier.status()
        assert not status.enabled
        assert status.muted
        assert not status.can_put_out_power

    def test_it_says_who_it_is(self, amplifier: PowerAmplifier) -> None:
        """Manufacturer or model at least."""
        assert amplifier.identity().manufacturer or amplifier.identity().model

    def test_it_is_healthy(self, amplifier: PowerAmplifier) -> None:
        """No fault, and a plausible temperature if it reports one."""
        status = amplifier.status()
        assert status.fault is None
        assert status.temperature_c is None or -40 < status.temperature_c < 120

    def test_enabling_leaves_it_muted(self, amplifier: PowerAmplifier) -> None:
        """Power needs two steps."""
        amplifier.enable()
        assert amplifier.status().enabled
        assert amplifier.status().muted
        amplifier.unmute()
        assert amplifier.status().can_put_out_power
        amplifier.mute()
        assert amplifier.status().muted

    def test_unmuting_needs_enabling(self, amplifier: PowerAmplifier) -> None:
        """DeviceStateError before."""
        amplifier.disable()
        with pytest.raises(DeviceStateError):
            amplifier.unmute()
        assert not amplifier.status().can_put_out_power

    def test_disabling_mutes_and_can_be_repeated(self, amplifier: PowerAmplifier) -> None:
        """In any state; enabling again does not unmute."""
        amplifier.enable()
        amplifier.unmute()
        for _ in range(2):
            amplifier.disable()
            assert not amplifier.status().enabled
            assert amplifier.status().muted
        amplifier.enable()
        assert amplifier.status().muted

    def test_a_reset_leaves_it_disabled(self, amplifier: PowerAmplifier) -> None:
        """Also without a fault."""
        amplifier.enable()
        amplifier.reset_fault()
        assert not amplifier.status().enabled
        assert amplifier.status().fault is None

    def test_a_trip_takes_the_power_away_at_once(self, amplifier: PowerAmplifier, trip: Callable[[], None]) -> None:
        """Enabled and unmuted as it was."""
        amplifier.enable()
        amplifier.unmute()
        trip()
        assert amplifier.status().fault
        assert not amplifier.status().can_put_out_power
        amplifier.reset_fault()

    def test_a_fault_stays_latched_until_it_is_reset(self, amplifier: PowerAmplifier, trip: Callable[[], None]) -> None:
        """Disabling does not clear it, enabling raises DeviceFault; after the reset the amplifier is as new."""
        trip()
        amplifier.disable()
        with pytest.raises(DeviceFault):
            amplifier.enable()
        assert amplifier.status().fault
        amplifier.reset_fault()
        assert amplifier.status().fault is None
        assert not amplifier.status().enabled
        amplifier.enable()
        assert amplifier.status().muted

    def test_any_thread_may_disable_it(self, amplifier: PowerAmplifier) -> None:
        """While another one talks to it."""
        amplifier.enable()
        thread = threading.Thread(target=amplifier.disable)
        thread.start()
        for _ in range(5):
            amplifier.status()
        thread.join(10)
        assert not amplifier.status().enabled
