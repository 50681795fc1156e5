"""Contract of the class-D power amplifier, all channels of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from drivers.identity import Identity


@dataclass(frozen=True, kw_only=True)
class AmplifierStatus:
    """Read-back: enabled, muted, fault text (None if healthy), heat-sink temperature in deg C (None if the amplifier
    does not report it), clipped since the last `enable()`."""

    enabled: bool
    muted: bool
    fault: str | None
    temperature_c: float | None
    clipped: bool

    @property
    def can_put_out_power(self) -> bool:
        """True if nothing but the gate line keeps power from the coils."""
        return self.enabled and not self.muted and self.fault is None


class PowerAmplifier(Protocol):
    """Class-D amplifier.  Power reaches the coils only if enabled, not muted, without fault, and while the card's line
    PA_GATE is high.  It starts disabled and muted, also after a reconnect.  A class that derives from this one inherits
    the defaults."""

    @property
    def on_card_lines(self) -> bool:
        """Whether the card's lines are its only wire, so that it is switched off after the card has been stopped."""
        return False

    def identity(self) -> Identity:
        """Identity of the amplifier.  Raises DeviceTimeout, DeviceProtocolError."""

    def status(self) -> AmplifierStatus:
        """Fresh read-back.  Raises DeviceTimeout, DeviceProtocolError."""

    def status_after_tx(self) -> AmplifierStatus:
        """What a shot has to know between TX and RX, where an answer that never comes costs it: fault and clipping.

        The temperature may be None.  Raises as `status`.
        """
        return self.status()

    def enable(self) -> None:
        """Switch the power stage on (still muted).  Raises DeviceFault if a fault is latched."""

    def disable(self) -> None:
        """Switch the power stage off and mute.  In any state; idempotent; any thread."""

    def mute(self) -> None:
        """Silence the outputs.  Idempotent."""

    def unmute(self) -> None:
        """Let the input through.  Raises DeviceStateError unless enabled."""

    def reset_fault(self) -> None:
        """Clear a latched fault; the amplifier is disabled and muted afterwards, whether it succeeds or not.

        Raises DeviceFault if the fault stays: its cause persists, or the amplifier has no reset command.
        """

    def close(self) -> None:
        """`disable()`, then release the device.  Idempotent."""
