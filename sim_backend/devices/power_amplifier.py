"""The simulated class-D power amplifier."""

from __future__ import annotations

from drivers.errors import DeviceFault, DeviceStateError
from drivers.identity import Identity
from drivers.power_amplifier import AmplifierStatus, PowerAmplifier
from sim_backend.world.world import World

WHERE = "simulated power amplifier"


class SimulatedPowerAmplifier(PowerAmplifier):
    """See drivers.power_amplifier.PowerAmplifier.  Any thread may call any method."""

    def __init__(self, world: World) -> None:
        self._world = world
        self.disable()

    def identity(self) -> Identity:
        """See PowerAmplifier."""
        return Identity("simulated", "three-channel class-D amplifier")

    def status(self) -> AmplifierStatus:
        """See PowerAmplifier."""
        self._world.refresh()
        with self._world.lock:
            power = self._world.power
            celsius = self._world.amplifier_temperature_c()
            return AmplifierStatus(
                enabled=power.enabled,
                muted=power.muted,
                fault=power.fault,
                temperature_c=celsius,
                clipped=power.clipped,
            )

    def enable(self) -> None:
        """See PowerAmplifier.  Muted if it was not enabled before."""
        self._world.refresh()
        with self._world.lock:
            power = self._world.power
            if power.fault is not None:
                raise DeviceFault(f"fault latched: {power.fault}", where=WHERE, remedy="reset the fault first")
            power.clipped = False
            self._world.amplifier(enabled=True, muted=power.muted or not power.enabled)

    def disable(self) -> None:
        """See PowerAmplifier."""
        self._world.amplifier(enabled=False, muted=True)

    def mute(self) -> None:
        """See PowerAmplifier."""
        self._world.amplifier(muted=True)

    def unmute(self) -> None:
        """See PowerAmplifier."""
        with self._world.lock:
            if not self._world.power.enabled:
                raise DeviceStateError("the amplifier is disabled", where=WHERE, remedy="enable it first")
            self._world.amplifier(muted=False)

    def reset_fault(self) -> None:
        """See PowerAmplifier."""
        fault = self._world.reset_amplifier()
        if fault is not None:
            raise DeviceFault(f"the fault stays: {fault}", where=WHERE, remedy="remove its cause")

    def close(self) -> None:
        """See PowerAmplifier."""
        self.disable()
