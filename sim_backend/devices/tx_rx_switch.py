"""The simulated Tx/Rx switch."""

from __future__ import annotations

from drivers.errors import DeviceFault, DeviceStateError
from drivers.identity import Identity
from drivers.tx_rx_switch import SwitchPosition, SwitchTiming, TxRxSwitch
from sim_backend.world.world import World

WHERE = "simulated Tx/Rx switch"


class SimulatedTxRxSwitch(TxRxSwitch):
    """See drivers.tx_rx_switch.TxRxSwitch.  Any thread may call any method."""

    def __init__(self, world: World) -> None:
        self._world = world

    def identity(self) -> Identity:
        """See TxRxSwitch."""
        return Identity("simulated", "three-pole relay with read-back")

    def timing(self) -> SwitchTiming:
        """See TxRxSwitch."""
        options = self._world.options.switch
        return SwitchTiming(dead_time_s=options.dead_time_s, bounce_s=options.bounce_s, settle_s=options.settle_s)

    def position(self) -> SwitchPosition:
        """See TxRxSwitch."""
        return self._world.contacts().position(self._world.clock.monotonic_s())

    def last_move_s(self, target: SwitchPosition) -> float | None:
        """See TxRxSwitch."""
        return self._world.contacts().last_move_s.get(target, 0.0)

    def to_transmit(self) -> None:
        """See TxRxSwitch.  Raises DeviceStateError while a timeline runs, because then the card's line commands the
        switch."""
        self._go(SwitchPosition.TRANSMIT)

    def to_receive(self) -> None:
        """See TxRxSwitch.  Raises DeviceStateError while a timeline runs, because then the card's line commands the
        switch."""
        self._go(SwitchPosition.RECEIVE)

    def close(self) -> None:
        """See TxRxSwitch.  While a timeline runs, its end moves the contacts to TRANSMIT."""
        if not self._world.is_running() and self.position() is not SwitchPosition.TRANSMIT:
            self.to_transmit()

    def _go(self, target: SwitchPosition) -> None:
        if self._world.is_running():
            raise DeviceStateError("a timeline is running", where=WHERE, remedy="stop the card first")
        wait_s = self._world.move_contacts(target) - self._world.clock.monotonic_s()
        if wait_s > 0:
            self._world.clock.sleep(wait_s * (1 + 1e-9) + 1e-9)
        found = self.position()
        if found is not target:
            raise DeviceFault(
                f"the contacts are on {found.value}, not on {target.value}", where=WHERE, remedy="check the relay"
            )
