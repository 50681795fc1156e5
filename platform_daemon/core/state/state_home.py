"""The folder for what programs of this account keep."""

from __future__ import annotations

import os
from pathlib import Path


def state_home() -> Path:
    """`$XDG_STATE_HOME`, `~/.local/state` without it; nothing is made.

    By the XDG base directory specification, which wants relative paths ignored.  Raises RuntimeError if the account has
    no home.
    """
    configured = Path(os.environ.get("XDG_STATE_HOME", ""))
    if configured.is_absolute():
        return configured
    home = Path.home()
    if not home.is_absolute() or os.environ.get("HOME") == "":  # for which Python says "/"
        raise RuntimeError("the account has no home")
    return home / ".local" / "state"
