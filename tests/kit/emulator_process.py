"""The emulated lab as a process of its own, as in a lab."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from platform_daemon.core.settings import locate
from tests.kit.command_line import COMMAND

STEADY = ("effects.temperature", "effects.friction_scatter", "effects.wear")
"""Tables of the world that are switched off: with them, series of the same seed differ if real time passes between
their shots."""


@contextmanager
def emulator(folder: Path, resonator: str) -> Iterator[tuple[Path, dict[str, Any]]]:
    """The emulated lab as a process of its own; the file of its endpoints, and what it says.

    Its cards write their sequence memory in no time: what is measured on it is the daemon's time.
    """
    shipped = locate("emulators", "lab")
    text = shipped.read_text().replace('"../', f'"{shipped.parent.parent}/').replace("thread.toml", f"{resonator}.toml")
    text = text.replace("\n[[io_cards.boards]]", "\n[[io_cards.boards]]\nmemory_access_s = 0.0")
    config, found = folder / "lab.toml", folder / "endpoints.json"
    config.write_text(text + "".join(f"\n[world.{table}]\nenabled = false\n" for table in STEADY))
    process = subprocess.Popen([COMMAND, "emulate", "--config", config, "--json", found], stdout=subprocess.DEVNULL)
    try:
        while not found.exists():
            if process.poll() is not None:
                raise SystemExit("the emulator did not start")
            time.sleep(0.05)
        yield found, json.loads(found.read_text())
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(timeout=30)
