"""What a process that is started anew is told: nothing that was changed meanwhile keeps it from serving as before.

A certificate that is being renewed, has expired or cannot be read any more would keep it away, and with it the port for
stop; tokens that are gone would not be demanded any more.
"""

from __future__ import annotations

import os
from pathlib import Path

from platform_daemon.store import tokens_in

from .options import ServeOptions


def options_anew(options: ServeOptions) -> tuple[ServeOptions, tuple[int, ...]]:
    """Its options, and the descriptors that it has to be handed: certificate, key and tokens as they are now, in
    memory.  What cannot be read now is left as it is: the first processes say so."""
    files = {"tls_cert": options.tls_cert, "tls_key": options.tls_key, "tokens_before": tokens_in(options.data).path}
    kept = {name: copy for name, path in files.items() if path is not None and (copy := _in_memory(path)) is not None}
    paths = {name: Path(f"/proc/self/fd/{number}") for name, number in kept.items()}
    return options.model_copy(update={"again": True, **paths}), tuple(kept.values())


def _in_memory(path: Path) -> int | None:
    try:
        if not path.is_file():
            return None
        content = path.read_bytes()
    except OSError:
        return None
    number = os.memfd_create("kept")  # its own name may be longer than one of these can be
    with open(number, "wb", closefd=False) as file:
        file.write(content)
    return number
