"""Who switches the outputs off when the process that lets power out can no longer do it."""

from __future__ import annotations

from typing import Protocol


class PowerGuard(Protocol):
    """Told by the thread that moves a shot, and by no other."""

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
