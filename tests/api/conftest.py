"""A client of a daemon on the simulated platform that has made one short recording; one per test module."""

import pytest
from starlette.testclient import TestClient

from platform_daemon.api.server import create_api
from platform_daemon.app import start_engine
from platform_daemon.engine.catalogue import open_catalogue
from platform_daemon.engine.job_records import JobRecords
from platform_daemon.settings import load_platform
from platform_daemon.store.data_folder import open_data_folder
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.linked_api import linked_context
from tests.kit.rest import finished


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = open_data_folder(tmp_path_factory.mktemp("data"))
    catalogue = open_catalogue(folder.resonators, folder.sequences)
    engine = start_engine(load_platform("simulated"), JobRecords(folder.jobs), catalogue=catalogue)
    api = create_api(linked_context(engine, folder))
    with TestClient(api, raise_server_exceptions=False, base_url="http://127.0.0.1") as test_client:
        test_client.folder, test_client.engine = folder, engine
        # Made first, at rest: what still swings after a cancelled series can make a shot too weak for a fit.
        answer = test_client.post("/acquisitions", json={**SHORT_JEWEL, "shots": 2, "operator": "me"})
        test_client.recording = finished(test_client, answer.headers["location"])["result"]["recording"]
        yield test_client
    engine.close()


@pytest.fixture(scope="module")
def recording(client):
    return client.recording
