"""Log events of a process that has no log of its own, as the guard."""

from __future__ import annotations

import json
import os
import sys


def log_event(event: str, **more: object) -> None:
    """Write a line of JSON to stderr, which is that of the owner; a stream that is closed or full loses the line."""
    try:
        os.write(sys.stderr.fileno(), (json.dumps({"event": event, **more}) + "\n").encode())
    except (OSError, ValueError):
        return
