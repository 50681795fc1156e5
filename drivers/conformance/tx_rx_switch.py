"""What every Tx/Rx switch must do."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from drivers.errors import DeviceStateError
from drivers.platform import Platform
from drivers.tx_rx_switch import SwitchPosition, TxRxSwitch


class SwitchContract:
    """Offer the fixture `switch` or `platform`.  A switch that only follows the card's line may refuse RECEIVE."""

    @pytest.fixture(scope="class")
    @classmethod
    def switch(cls, platform: Platform) -> TxRxSwitch:
        """The switch under test."""
        return platform.switch

    @pytest.fixture(autouse=True)
    def _home(self, switch: TxRxSwitch) -> Iterator[None]:
        yield
        switch.to_transmit()

    def test_it_rests_on_transmit(self, switch: TxRxSwitch) -> None:
        """So it must be the first test that runs."""
        assert switch.position() is SwitchPosition.TRANSMIT

    def test_it_says_who_it_is(self, switch: TxRxSwitch) -> None:
        """Manufacturer or model at least."""
        assert switch.identity().manufacturer or switch.identity().model

    def test_its_times_are_constant_and_make_sense(self, switch: TxRxSwitch) -> None:
        """Between nothing and a second."""
        timing = switch.timing()
        assert timing == switch.timing()
        assert min(timing.dead_time_s, timing.bounce_s, timing.settle_s) >= 0
        assert 0 < timing.total_s < 1

    def test_a_command_returns_when_the_contacts_have_arrived(self, switch: TxRxSwitch) -> None:
        """To RECEIVE and back, each commanded twice; or RECEIVE is refused, and the contacts stay on TRANSMIT."""
        try:
            switch.to_receive()
        except DeviceStateError:
            assert switch.position() is SwitchPosition.TRANSMIT
            return
        assert switch.position() is SwitchPosition.RECEIVE
        switch.to_receive()
        assert switch.position() is SwitchPosition.RECEIVE
        switch.to_transmit()
        assert switch.position() is SwitchPosition.TRANSMIT
        switch.to_transmit()
        assert switch.position() is SwitchPosition.TRANSMIT

    def test_it_has_measured_its_moves_or_says_that_it_does_not(self, switch: TxRxSwitch) -> None:
        """Within what `timing()` promises."""
        try:
            switch.to_receive()
            switch.to_transmit()
        except DeviceStateError:
            pass
        timing = switch.timing()
        for target in (SwitchPosition.RECEIVE, SwitchPosition.TRANSMIT):
            took_s = switch.last_move_s(target)
            assert took_s is None or 0 <= took_s <= 1.1 * (timing.dead_time_s + timing.bounce_s) + 1e-3
