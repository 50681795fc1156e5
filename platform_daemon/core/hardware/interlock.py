"""No power before outputs are proved off: a platform that once could not be switched off stays locked."""

from __future__ import annotations

from collections.abc import Callable

import structlog

from drivers.errors import InterlockError, OutputsUnconfirmed, PlatformError
from drivers.platform import Platform
from platform_daemon.core.jobs.events import EventSink, null_sink
from platform_daemon.core.jobs.jobs import AnyJob
from platform_daemon.core.schemas.events import InterlockEvent

log = structlog.get_logger()


class Interlock:
    """Stands before all work on a platform.  why: how the last attempt to switch them off failed; None: it is open.

    tell: when it closes, and when it is open again.
    """

    def __init__(self, platform: Platform, tell: EventSink = null_sink) -> None:
        self._platform, self._tell = platform, tell
        self.why: str | None = None
        self._told: str | None = None

    def prove_off(self) -> None:
        """Outputs off and confirmed, else `why` says why.  Raises DeviceError."""
        try:
            self._platform.outputs_off()
        except Exception as error:
            self._set(str(error))
            raise
        self._set(None)

    @property
    def stands(self) -> str | None:
        """Why power must stay off: `why`, or a guard's refusal; None: power may go out."""
        refusal = self._platform.guard.refusal()
        return self.why or (None if refusal is None else str(refusal))

    def refuse(self) -> None:
        """Raises InterlockError while the guard lets no power out: nothing is begun then."""
        refusal = self._platform.guard.refusal()
        if refusal is not None:
            raise refusal

    def run(self, work: Callable[[AnyJob], None], job: AnyJob) -> None:
        """Do the work of a job, with outputs proved off before and after.

        Raises InterlockError before anything moves, DeviceError, and what the work raises.
        """
        try:
            self.prove_off()
        except PlatformError as error:
            remedy = "switch the amplifier's mains off by hand, repair the device named, then POST /stop to prove it"
            raise InterlockError("outputs cannot be confirmed off", why=str(error), remedy=remedy) from None
        try:
            work(job)
        except OutputsUnconfirmed as error:  # tried a moment ago: the user hears of it now, `recover` continues
            self._set(str(error))
            raise
        except BaseException:
            self.prove_off()
            raise
        self.prove_off()

    def recover(self) -> None:
        """Outputs that could not be confirmed off are switched off again and again, until they are."""
        self._look()
        if self.why is None:
            return
        try:
            self.prove_off()
            log.info("outputs_confirmed_off")
        except Exception as error:  # said already, and tried again a moment later
            log.warning("outputs_unconfirmed", error=str(error))

    def _set(self, why: str | None) -> None:
        self.why = why
        self._look()

    def _look(self) -> None:
        """EventSink if it has closed, for this reason, or is open again."""
        stands = self.stands
        if stands != self._told:
            self._told = stands
            self._tell(InterlockEvent(why=stands))
