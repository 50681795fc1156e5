"""An engine on the simulated platform behind a socket; one per test module."""

import pytest

from platform_daemon.app import start_engine
from platform_daemon.engine.catalogue import open_catalogue
from platform_daemon.engine.job_records import JobRecords
from platform_daemon.link.client import RemoteHardware
from platform_daemon.link.owner import OwnedHardware
from platform_daemon.link.plans import Folders
from platform_daemon.link.server import LinkServer
from platform_daemon.settings import load_platform
from platform_daemon.store.data_folder import open_data_folder


class Linked:
    """Both ends."""

    def __init__(self, folder):
        self.data = open_data_folder(folder)
        self.engine = start_engine(
            load_platform("simulated"),
            JobRecords(self.data.jobs),
            catalogue=open_catalogue(self.data.resonators, self.data.sequences),
        )
        data = self.data
        self.folders = Folders(
            data.recordings, data.procedures, data.characterisations, data.calibrations, data.mounted
        )
        self.owned, self.folder = OwnedHardware(self.engine, self.folders), folder
        self.server = LinkServer(lambda: self.owned, folder)
        self.remote = RemoteHardware(folder, patience_s=20)


@pytest.fixture(scope="module")
def linked(tmp_path_factory):
    made = Linked(tmp_path_factory.mktemp("data"))
    yield made
    made.remote.close()
    made.server.close()
    made.engine.close()


@pytest.fixture
def linked_in():
    """Makes one in a folder."""
    return Linked
