"""What the command line writes into the audit log of a daemon."""

from __future__ import annotations

import getpass
import os
import sys
from datetime import UTC, datetime
from pathlib import Path


def audit(data: Path, what: str, change: str) -> None:
    """Append a line to the audit log of a data folder, as the web process does for a request.

    what: the action, such as `token_add`; change: what was changed, in words.  There is no HTTP request, so path and
    status are empty.  Raises StorageError.
    """
    from platform_daemon.core.schemas.access import AuditEntry
    from platform_daemon.core.state.audit import audit_log_in

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


def audit_done(data: Path, what: str, change: str) -> None:
    """The same for what has been done already: a disk that refuses the line is a warning, and no failure."""
    from platform_daemon.core.state.errors import StorageError

    try:
        audit(data, what, change)
    except StorageError as error:
        print(f"warning: {error}", file=sys.stderr)


def audit_in(folder: Path, what: str, change: str) -> None:
    """The same, if `folder` is one of the data folder of a daemon: what it finds there it uses."""
    from platform_daemon.core.recordings.data_folder import is_data_folder

    data = folder.resolve().parent
    if is_data_folder(data):
        audit_done(data, what, change)


def _user() -> str:
    """Name of the user, who may have none."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return f"uid {os.getuid()}"
