"""`platform-daemon serve`: the daemon with its REST interface."""

from __future__ import annotations

import logging
import socket
from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import InputError

from .interrupts import heed_one_interrupt
from .logs import log_from
from .options import EndpointsOption, PlatformOption, SetOption, library


def serve(
    platform: PlatformOption = "simulated",
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port to listen on; 0: any free one.", min=0, max=65535)] = 8212,
    data: Annotated[Path, typer.Option(help="Folder of recordings and fits.")] = Path("data"),
    resonators: Annotated[Path | None, typer.Option(help="Folder of further resonator files, by name.")] = None,
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
) -> None:
    """Run the daemon until SIGTERM or Ctrl-C; outputs go off first."""
    from platform_daemon.api import Server, create_api
    from platform_daemon.app import create_context, start_engine
    from platform_daemon.engine import JobRecords, open_catalogue
    from platform_daemon.settings import load_platform
    from platform_daemon.store import open_data_folder

    log_from(logging.INFO)
    file = load_platform(platform, overrides or (), endpoints)
    listener = _listen(host, port)
    folder = open_data_folder(data)
    # uvicorn raises the signal again when it has ended; it must then not kill us before the series is put together.
    heed_one_interrupt()
    catalogue = open_catalogue(folder.resonators, folder.sequences, resonators, folder.presets)
    engine = start_engine(file, JobRecords(folder.jobs), library(folder.models), catalogue)
    try:
        server = Server(create_api(create_context(engine, folder)), engine, host, port)
        print(f"listening on http://{host}:{listener.getsockname()[1]}", flush=True)
        server.run(sockets=[listener])
    except KeyboardInterrupt:
        pass
    finally:
        engine.close()


def _listen(host: str, port: int) -> socket.socket:
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(128)
    except OSError as error:
        why = error.strerror or str(error)
        raise InputError("cannot listen", where=f"{host}:{port}", why=why, remedy="choose another --port") from None
    return listener
