"""Records in the audit log what a request has changed."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime

import structlog
from starlette.requests import Request

from drivers.errors import InputError, PlatformError
from platform_daemon.core.schemas.access import AuditEntry
from platform_daemon.core.state.audit import AuditLog
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.web.own_thread import run_in_own_thread

from .callers import Caller

log = structlog.get_logger()
MAX_CHARACTERS = 2000  # of a path, and of a request
FAILED = 500  # status of every error that is not the caller's


@dataclass(frozen=True)
class Auditor:
    """Records the outcome of one request; log: None records nothing."""

    log: AuditLog | None
    caller: Caller
    operation: str
    request: Request
    body: bytes

    async def done(self, status: int) -> None:
        """The request was carried out."""
        await self._write(status, "done")

    async def failed(self, error: PlatformError) -> None:
        """The request was begun and failed; one that was refused at once changed nothing, and is not recorded."""
        if not isinstance(error, InputError):
            await self._write(FAILED, str(error))

    async def _write(self, status: int, outcome: str) -> None:
        log_file = self.log
        if log_file is None:
            return
        url = self.request.url
        entry = AuditEntry(
            when=datetime.now(UTC).isoformat(timespec="milliseconds"),
            who=self.caller.name,
            address=self.caller.address,
            what=self.operation,
            path=(f"{url.path}?{url.query}" if url.query else url.path)[:MAX_CHARACTERS],
            request=self.body.decode("utf-8", "replace")[:MAX_CHARACTERS],
            status=status,
            outcome=outcome,
        )
        try:
            await run_in_own_thread(lambda: log_file.append(entry))
        except StorageError as error:  # what was done is done: its answer must not say otherwise
            log.error("audit_failed", entry=entry.model_dump(), error=str(error))
