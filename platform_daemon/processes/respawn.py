"""The options of a process that is started again: it serves as before, whatever has changed in files meanwhile.

A certificate that is being renewed, has expired or cannot be read any more would keep the process away, and with it the
stop port; if the file of tokens had been removed, none would be demanded any more.
"""

from __future__ import annotations

import os
from pathlib import Path

from platform_daemon.core.state.tokens import tokens_in

from .options import ServeOptions


def respawn_options(options: ServeOptions) -> tuple[ServeOptions, tuple[int, ...]]:
    """The options, and the file descriptors that the process must inherit: certificate, key and tokens as they are now,
    copied into memory.  A file that cannot be read now keeps its path; the first processes report it."""
    files = {"tls_cert": options.tls_cert, "tls_key": options.tls_key, "initial_tokens": tokens_in(options.data).path}
    copies = {
        name: copy for name, path in files.items() if path is not None and (copy := _copy_in_memory(path)) is not None
    }
    paths = {name: Path(f"/proc/self/fd/{descriptor}") for name, descriptor in copies.items()}
    return options.model_copy(update={"respawned": True, **paths}), tuple(copies.values())


def _copy_in_memory(path: Path) -> int | None:
    try:
        if not path.is_file():
            return None
        content = path.read_bytes()
    except OSError:
        return None
    descriptor = os.memfd_create("kept")  # a file name may be longer than the name of such a file can be
    with open(descriptor, "wb", closefd=False) as file:
        file.write(content)
    return descriptor
