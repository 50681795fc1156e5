"""Who switches the outputs off when the process that lets power out can no longer do it."""

from __future__ import annotations

from typing import Protocol

from drivers.errors import InterlockError


class PowerGuard(Protocol):
    """Told by the thread that moves a shot, and by no other; `refusal` and `reset` may be asked by any."""

    def watch(self) -> None:
        """Begin to watch now, so that the first power need not wait for it."""

    def refusal(self) -> InterlockError | None:
        """Why no power may come: a fault that no person has reset, a lease beyond the limit; None: it may."""

    def unfit(self) -> InterlockError | None:
        """Why no power will ever come as the platform is set, a lease beyond the limit; None: it may."""

    def reset(self, by: str, reason: str) -> str | None:
        """Clear a fault in the name of a person; what it was, None: there was none.

        Outputs must have been proved off just before.  Raises InputError without a name, DeviceError.
        """

    def power_may_come(self) -> None:
        """From now on signs of life are expected.  Raises InterlockError if nobody would see them."""

    def alive(self) -> None:
        """A sign of life; one is due at least every LEASE_S while power may come."""

    def switching_off(self) -> None:
        """Outputs are being switched off, which devices that do not answer may draw out."""

    def power_is_off(self) -> None:
        """All outputs are confirmed off."""

    def close(self) -> None:
        """The devices have been let go, with outputs off; harmless to repeat."""


class NoGuard:
    """For devices that die with the process, as simulated ones do."""

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
