"""What the command line writes into the audit log of a daemon."""

from __future__ import annotations

import getpass
import os
from datetime import UTC, datetime
from pathlib import Path


def audit(data: Path, what: str, change: str) -> None:
    """A line in the audit log of a data folder.  Raises StorageError."""
    from platform_daemon.schemas import AuditEntry
    from platform_daemon.store import audit_log_in

    entry = AuditEntry(
        when=datetime.now(UTC).isoformat(timespec="milliseconds"),
        who=_user(),
        address="command line",
        what=what,
        path="",
        request=change,
        status=0,
        outcome="done",
    )
    audit_log_in(data).append(entry)


def _user() -> str:
    """Name of the user, who may have none."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return f"uid {os.getuid()}"
