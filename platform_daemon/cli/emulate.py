"""`platform-daemon emulate`: the lab's devices behind their real wires, for tests and for trying drivers."""

from __future__ import annotations

import json
import threading
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import ConfigError
from platform_daemon.core.command_line.interrupts import heed_one_interrupt

CLOSE_S = 10.0


def emulate(
    config: Annotated[str, typer.Option(help="Emulator file, or the name of a shipped one.")] = "lab",
    json_file: Annotated[
        Path | None, typer.Option("--json", help="File that lists the endpoints; it appears when all listen.")
    ] = None,
    name: Annotated[str, typer.Option("--emulator", help="Which installed emulator.")] = "lab",
) -> None:
    """Emulate I/O cards, serial devices and the USB amplifier until SIGTERM or Ctrl-C."""
    from drivers.registry import load_emulator
    from platform_daemon.core.settings import locate, read_toml

    path = locate("emulators", config)
    from platform_daemon.core.hardware.latency import reduce_latency  # here, because all commands import this module

    tables, _ = read_toml(path)
    heed_one_interrupt()
    try:
        emulator = load_emulator(name, tables, path.parent)
    except ConfigError as error:
        where = f"{path}: {error.where}" if error.where else str(path)
        raise ConfigError(error.what, where=where, why=error.why, remedy=error.remedy) from None
    written = None
    try:
        reduce_latency()
        written = json.dumps(emulator.endpoints(), indent=2) + "\n"
        _announce(written, json_file)
        threading.Event().wait()
    except KeyboardInterrupt:
        pass
    finally:
        closing = threading.Thread(target=emulator.close, daemon=True)
        closing.start()
        closing.join(CLOSE_S)  # whatever hangs in there, the process ends
        _withdraw(json_file, written)


def _announce(text: str, target: Path | None) -> None:
    """Show where everything listens; the file appears whole or not at all."""
    if target is not None:
        from platform_daemon.core.state.durable import write_file  # here, because HDF5 is loaded with it

        write_file(target, text.encode())
    print(text, end="", flush=True)


def _withdraw(target: Path | None, written: str | None) -> None:
    """Remove the file, if it is still the one that was written here."""
    with suppress(OSError):
        if target is not None and written is not None and target.read_text(encoding="utf-8") == written:
            target.unlink()
