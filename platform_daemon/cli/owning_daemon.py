"""The program that owns the devices of a platform, which a command asks before it opens any of them."""

from __future__ import annotations

import errno
import os
import pwd
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import DeviceDenied

if TYPE_CHECKING:
    from drivers.registry import PlatformSection


def daemon_of(section: PlatformSection) -> Path | None:
    """Data folder of the daemon that owns the devices, whatever its account; None: no program owns them.

    Raises DeviceDenied for a command that does, such as `measure`, and for a daemon of another account.
    """
    from drivers.registry import outputs_outlive_process
    from platform_daemon.core.guard.ownership import Owner, owner_of_devices
    from platform_daemon.core.service.address import NAME

    owner: Owner | None = owner_of_devices(section) if outputs_outlive_process(section) else None
    if owner is None or not owner.lives:
        return None
    if owner.data is None:
        remedy = f"end it: Ctrl-C in its terminal, or `kill {owner.pid}`, switches its outputs off"
        raise DeviceDenied("another program owns the devices", where="platform", why=f"it is {owner}", remedy=remedy)
    data = Path(owner.data)
    hidden = _why_hidden(data / NAME)
    if hidden is not None:
        who = _account_of(owner.pid)
        remedy = f"run this command as {who} or as root; to stop everything, POST /stop to its stop port"
        why = f"it is {owner}; {data / NAME}: {hidden}"
        raise DeviceDenied("the daemon cannot be reached from this account", where="platform", why=why, remedy=remedy)
    return data


def _why_hidden(path: Path) -> str | None:
    """Why this account cannot use the socket; None: it can, or could if it were there, which is waited for."""
    try:
        path.parent.stat()
        path.stat()
    except FileNotFoundError as error:
        return None if error.filename == str(path) else error.strerror
    except OSError as error:
        return error.strerror
    return None if os.access(path, os.R_OK | os.W_OK) else os.strerror(errno.EACCES)


def _account_of(pid: int) -> str:
    """Name of the account of a process."""
    try:
        number = os.stat(f"/proc/{pid}").st_uid
    except OSError:
        return "its account"
    try:
        return f"the account {pwd.getpwuid(number).pw_name}"
    except KeyError:
        return f"the account {number}"
