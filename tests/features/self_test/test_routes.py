import time

import pytest
from starlette.testclient import TestClient

from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.settings import load_platform
from platform_daemon.core.web.server import create_api
from platform_daemon.processes.assembly import start_engine
from tests.kit.linked_api import linked_context


@pytest.fixture
def client_of(tmp_path):
    """A client of a platform with overrides."""
    engines = []

    def make(*overrides):
        folder = open_data_folder(tmp_path)
        engines.append(start_engine(load_platform("simulated", overrides), JobRecords(folder.state)))
        api = create_api(linked_context(engines[-1], folder))
        return TestClient(api, raise_server_exceptions=False, base_url="http://127.0.0.1")

    yield make
    for engine in engines:
        engine.close()


def ended(client, location):
    deadline = time.monotonic() + 60
    while (job := client.get(location).json())["state"] not in ("done", "failed", "cancelled"):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return job


def test_is_accepted_and_says_what_it_heard(client_of):
    client = client_of()
    answer = client.post("/self-tests", json={"operator": "me"})
    assert answer.status_code == 202
    job = ended(client, answer.headers["location"])
    assert (job["state"], job["request"]["operator"]) == ("done", "me")
    assert {*job["result"]["gain"]} == {*job["result"]["isolation_db"]} == {"x", "y", "z"}
    assert [each["id"] for each in client.get("/self-tests").json()["items"]] == [job["id"]]


def test_a_wrong_chain_is_named(client_of):
    client = client_of("backends.simulated.wiring.factors=[1.0, 1.0, 0.5]")
    job = ended(client, client.post("/self-tests", json={}).headers["location"])
    assert (job["state"], job["result"]) == ("failed", {})
    assert job["error"]["type"].endswith("self-test-failed")
    assert "the gain of z" in job["error"]["detail"]


def test_one_that_waits_is_cancelled(client_of):
    client = client_of('backends.simulated.clock.mode="realtime"')
    series = client.post("/acquisitions", json={"resonator": "jewel", "sequence": {"rx_s": 5.0}}).headers["location"]
    waiting = client.post("/self-tests", json={}).headers["location"]
    assert client.delete(waiting).json()["state"] == "cancelled"
    assert client.get(series).json()["state"] in ("queued", "running")
    client.delete(series)
    assert ended(client, series)["state"] == "cancelled"
