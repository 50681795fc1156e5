"""Writes what a request has changed into the audit log."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime

import anyio
import structlog
from starlette.requests import Request

from drivers.errors import InputError, PlatformError
from platform_daemon.schemas import AuditEntry
from platform_daemon.store import AuditLog, StorageError

from .callers import Caller

log = structlog.get_logger()
LONGEST = 2000  # characters of a path, and of a request
FAILED = 500  # what an error is called that is not the caller's; the log of the server has the answer's own status


@dataclass(frozen=True)
class Auditor:
    """One request; log None: nothing is written."""

    log: AuditLog | None
    caller: Caller
    operation: str
    request: Request
    body: bytes

    async def done(self, status: int) -> None:
        """It was carried out."""
        await self._write(status, "done")

    async def failed(self, error: PlatformError) -> None:
        """It was begun and failed; what was refused at once has changed nothing, and is not written."""
        if not isinstance(error, InputError):
            await self._write(FAILED, str(error))

    async def _write(self, status: int, outcome: str) -> None:
        if self.log is None:
            return
        url = self.request.url
        entry = AuditEntry(
            when=datetime.now(UTC).isoformat(timespec="milliseconds"),
            who=self.caller.name,
            address=self.caller.address,
            what=self.operation,
            path=(f"{url.path}?{url.query}" if url.query else url.path)[:LONGEST],
            request=self.body.decode("utf-8", "replace")[:LONGEST],
            status=status,
            outcome=outcome,
        )
        try:
            # A thread of its own: those that all others share may be taken.
            await anyio.to_thread.run_sync(self.log.append, entry, limiter=anyio.CapacityLimiter(1))
        except StorageError as error:  # what was done is done: its answer must not say otherwise
            log.error("audit_failed", entry=entry.model_dump(), error=str(error))
