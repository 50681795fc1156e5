"""The API as it is served: over the local socket to an engine, which tests can reach into."""

from __future__ import annotations

from platform_daemon.api import Context
from platform_daemon.app import create_context
from platform_daemon.engine import Engine
from platform_daemon.link import Folders, LinkServer, OwnedHardware, RemoteHardware
from platform_daemon.store import DataFolder


def linked_context(engine: Engine, data: DataFolder) -> Context:
    """A context whose hardware is that engine, on the other end of a socket in the data folder."""
    folders = Folders(data.recordings, data.procedures, data.characterisations, data.calibrations, data.mounted)
    engine.warm_up_fits()
    owned, folder = OwnedHardware(engine, folders), data.recordings.parent
    LinkServer(lambda: owned, folder)
    return create_context(RemoteHardware(folder), data, engine.catalogue)
