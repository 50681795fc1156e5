"""The daemon as a process of its own, on the simulated platform."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.kit.command_line import COMMAND


@contextmanager
def daemon(data: Path, *options: str) -> Iterator[str]:
    """Its address.  Its log is beside the folder of its data; that it leaves cleanly on SIGTERM is asserted."""
    command = [COMMAND, "serve", "--port", "0", "--data", data, *options]
    with data.with_suffix(".log").open("w") as log:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True)
        assert process.stdout is not None
        try:
            yield process.stdout.readline().split()[-1]
        finally:
            process.send_signal(signal.SIGTERM)
            process.stdout.read()
            code = process.wait(timeout=60)
    assert code == 0
