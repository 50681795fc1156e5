"""The last shot at a glance, while a series runs."""

from __future__ import annotations

from platform_daemon.core.schemas.harmonics import ShotHarmonics


class LiveEstimate:
    """Holds what the harmonics of the last excited shot tell; one thread writes it, anybody may read it."""

    latest: ShotHarmonics | None = None

    def see(self, acquisition: str, shot: int, found: ShotHarmonics) -> None:
        """Those of shot number `shot` (from 1) of an acquisition."""
        self.latest = ShotHarmonics(found.root.model_copy(update={"acquisition": acquisition, "shot": shot}))
