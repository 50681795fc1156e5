"""Contract of the low-noise amplifier in front of the ADC."""

from __future__ import annotations

from typing import Protocol

from drivers.identity import Identity


class Lna(Protocol):
    """Low-noise amplifier, one gain for all channels."""

    def identity(self) -> Identity:
        """Identity of the amplifier.  Raises DeviceTimeout, DeviceProtocolError."""

    def gains(self) -> tuple[float, ...]:
        """The gains it can be set to, V/V, rising."""

    def gain(self) -> float:
        """The gain it is set to, V/V, read back."""

    def set_gain(self, gain: float) -> None:
        """Set one of `gains()`; any other value raises InputError, it is never rounded."""

    def overloaded(self) -> bool:
        """True if a channel was overloaded since the last `clear_overload()`."""

    def clear_overload(self) -> None:
        """Forget past overloads."""

    def close(self) -> None:
        """Release the device.  Idempotent."""
