"""The simulated low-noise amplifier."""

from __future__ import annotations

from drivers.errors import DeviceFault, DeviceStateError, InputError
from drivers.identity import Identity
from sim_backend.options import LnaTable
from sim_backend.world.world import World

WHERE = "simulated LNA"


class SimulatedLna:
    """See drivers.lna.Lna.

    Transmit power at the input destroys the LNA: overload stays latched and gain commands raise DeviceFault until the
    world is repaired.
    """

    def __init__(self, world: World, table: LnaTable) -> None:
        self._world = world
        self.set_gain(table.gain)

    def identity(self) -> Identity:
        """See Lna."""
        return Identity("simulated", "three-channel LNA")

    def gains(self) -> tuple[float, ...]:
        """See Lna."""
        return self._world.options.lna.gains

    def gain(self) -> float:
        """See Lna.  Raises DeviceFault if destroyed."""
        self._check_alive()
        return self._world.lna_gain

    def set_gain(self, gain: float) -> None:
        """See Lna.  Also raises DeviceStateError while a timeline runs, DeviceFault if destroyed."""
        if gain not in self.gains():
            raise InputError(f"no gain {gain}", where=WHERE, remedy=f"use one of {self.gains()}")
        self._check_alive()
        if self._world.is_running():
            raise DeviceStateError(
                "the gain cannot change while a timeline runs", where=WHERE, remedy="set it between shots"
            )
        self._world.lna_gain = gain

    def overloaded(self) -> bool:
        """See Lna."""
        self._world.refresh()
        return self._world.lna_overloaded

    def clear_overload(self) -> None:
        """See Lna.  A destroyed LNA stays overloaded."""
        self._world.refresh()
        with self._world.lock:
            self._world.lna_overloaded = self._world.lna_broken

    def close(self) -> None:
        """See Lna."""

    def _check_alive(self) -> None:
        self._world.refresh()
        if self._world.lna_broken:
            raise DeviceFault("the LNA was destroyed by transmit power", where=WHERE, remedy="replace it")
