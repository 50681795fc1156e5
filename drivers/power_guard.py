"""Contract of the guard, which switches the outputs off when the process that owns them can no longer do so."""

from __future__ import annotations

from typing import Protocol

from drivers.errors import InterlockError


class PowerGuard(Protocol):
    """Called by the thread that runs a shot alone, except `refusal` and `reset`, which any thread may call."""

    def watch(self) -> None:
        """Start watching now, so that the first shot need not wait for it."""

    def refusal(self) -> InterlockError | None:
        """Why no power is allowed: a fault that no person has reset, a lease beyond the limit; None: it is allowed."""

    def unfit(self) -> InterlockError | None:
        """Why the configuration never allows power, a lease beyond the limit; None: it does allow it."""

    def reset(self, by: str, reason: str) -> str | None:
        """Clear a fault in the name of a person; what it was, None: there was none.

        Outputs must have been proved off just before.  Raises InputError without a name, DeviceError.
        """

    def power_may_come(self) -> None:
        """From now on signs of life are expected.  Raises InterlockError if no guard process answers."""

    def alive(self) -> None:
        """A sign of life; one is due at least every LEASE_S while power may come."""

    def switching_off(self) -> None:
        """Outputs are being switched off, which takes longer if a device does not answer."""

    def power_is_off(self) -> None:
        """All outputs are confirmed off."""

    def close(self) -> None:
        """The devices have been released, with outputs off.  Idempotent."""


class NoGuard:
    """For devices that end with the process, as simulated ones do."""

    def watch(self) -> None:
        """See PowerGuard."""

    def refusal(self) -> InterlockError | None:
        """See PowerGuard."""
        return None

    def unfit(self) -> InterlockError | None:
        """See PowerGuard."""
        return None

    def reset(self, by: str, reason: str) -> str | None:
        """See PowerGuard."""
        return None

    def power_may_come(self) -> None:
        """See PowerGuard."""

    def alive(self) -> None:
        """See PowerGuard."""

    def switching_off(self) -> None:
        """See PowerGuard."""

    def power_is_off(self) -> None:
        """See PowerGuard."""

    def close(self) -> None:
        """See PowerGuard."""
