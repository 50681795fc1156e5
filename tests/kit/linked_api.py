"""The API as it is served: over the local socket to an engine, which tests can reach into."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.recordings.data_folder import DataFolder
from platform_daemon.core.service.bench import Folders
from platform_daemon.core.service.local import LocalPlatformService
from platform_daemon.core.service.proxy import PlatformServiceProxy
from platform_daemon.core.service.server import LinkServer
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.web.context import Context
from platform_daemon.processes.assembly import create_context


def linked_context(engine: Engine, data: DataFolder) -> Context:
    """A context whose hardware is that engine, on the other end of a socket in the data folder."""
    engine.warm_up_fits()
    owned, folder = LocalPlatformService(engine, folders_of(data)), data.recordings.parent
    LinkServer(services_of(owned), folder)
    return create_context(PlatformServiceProxy(folder), data, engine.catalogue)


def folders_of(data: DataFolder) -> Folders:
    """Where the hardware process of a data folder writes."""
    return Folders(
        recordings=data.recordings,
        procedures=data.procedures,
        characterisations=data.characterisations,
        reproductions=data.reproductions,
        calibrations=data.calibrations,
        mounted=data.mounted,
    )


def services_of(owned: LocalPlatformService, schedules: Any = None) -> Callable[[str], Any]:
    """The services of a hardware process by name."""

    def service(name: str) -> Any:
        if name == "schedules" and schedules is None:
            raise StorageError("there are no schedules here", remedy="ask a daemon (`platform-daemon serve`)")
        return schedules if name == "schedules" else owned

    return service
