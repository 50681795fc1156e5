import time

import pytest
from starlette.testclient import TestClient

from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.recordings.reader import read_calibration
from platform_daemon.core.settings import load_platform
from platform_daemon.core.web.server import create_api
from tests.kit.linked_api import linked_context

SHORT = {"kind": "receive", "frequencies_hz": [212.0, 424.0], "repetitions": 1}


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    from platform_daemon.processes.assembly import start_engine

    folder = open_data_folder(tmp_path_factory.mktemp("data"))
    engine = start_engine(load_platform("simulated"), JobRecords(folder.state))
    with TestClient(
        create_api(linked_context(engine, folder)), raise_server_exceptions=False, base_url="http://127.0.0.1"
    ) as test_client:
        test_client.folder, test_client.engine = folder, engine
        yield test_client
    engine.close()


def until(client, location, condition):
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        job = client.get(location).json()
        if condition(job):
            return job
        time.sleep(0.02)
    raise AssertionError(f"{location}: {job}")


def ended(job):
    return job["state"] in ("done", "failed", "cancelled")


def test_a_calibration_is_accepted_with_a_location_and_ends_with_a_file(client):
    answer = client.post("/calibrations", json={**SHORT, "name": "lab"})
    assert answer.status_code == 202
    job = until(client, answer.headers["location"], ended)
    assert job["state"] == "done"
    assert job["progress"]["done"] == job["progress"]["total"] == 6
    assert job["result"]["calibration"].startswith("lab@1_")
    made = read_calibration(client.folder.calibrations / job["result"]["file"])
    assert made.sensitivity.tolist() == job["result"]["sensitivity_t_per_a"]
    assert [j["id"] for j in client.get("/calibrations").json()["items"]] == [job["id"]]


def test_the_smallest_tone_makes_a_calibration_and_a_smaller_one_is_refused_at_once(client):
    asked = {"kind": "transmit", "frequencies_hz": [212.0, 424.0], "repetitions": 1}
    location = client.post("/calibrations", json={**asked, "amplifier_v": 1e-3}).headers["location"]
    assert until(client, location, ended)["state"] == "done"
    for tiny in (5e-324, 0.999e-3):
        answer = client.post("/calibrations", json={**asked, "amplifier_v": tiny})
        assert answer.status_code == 422
        assert "at least 0.001 V" in answer.text


def test_waits_for_the_operator_and_goes_on_when_told(client, monkeypatch):
    dipole = client.engine.platform.reference
    turn = dipole.turn
    monkeypatch.setattr(dipole, "turn", lambda axis: not turn(axis))
    location = client.post("/calibrations", json=SHORT).headers["location"]
    for axis in "xyz":
        job = until(client, location, lambda j, a=axis: j["question"] and f"along {a}" in j["question"])
        assert client.post(job["links"]["continue"], json={}).status_code == 200
    job = until(client, location, ended)
    assert (job["state"], job["question"]) == ("done", None)
    assert client.post(f"{location}/continue", json={}).status_code == 409


def test_a_waiting_calibration_can_be_cancelled_and_leaves_no_file(client, monkeypatch):
    monkeypatch.setattr(client.engine.platform.reference, "turn", lambda axis: False)
    before = sorted(client.folder.calibrations.iterdir())
    location = client.post("/calibrations", json=SHORT).headers["location"]
    until(client, location, lambda j: j["question"])
    assert client.get("/platform").json()["running"] == location.rpartition("/")[2]
    assert client.delete(location).status_code == 202
    assert until(client, location, ended)["state"] == "cancelled"
    assert sorted(client.folder.calibrations.iterdir()) == before


@pytest.mark.parametrize(
    ("body", "place"),
    [
        ({"kind": "both"}, "kind"),
        ({**SHORT, "frequencies_hz": [212.0]}, "frequencies_hz"),
        ({**SHORT, "frequencies_hz": [212.0, 15e3]}, "frequency_hz"),
        ({**SHORT, "name": "../x"}, "name"),
        ({"kind": "transmit", "amplifier_v": 8.9}, "field_t"),
    ],
)
def test_a_bad_request_is_a_422_problem_and_nothing_moves(client, body, place):
    jobs = len(client.get("/calibrations").json()["items"])
    answer = client.post("/calibrations", json=body)
    assert answer.status_code == 422
    assert place in answer.json()["where"]
    assert len(client.get("/calibrations").json()["items"]) == jobs


def test_a_calibration_is_in_use_from_the_moment_it_is_adopted(client):
    job = until(client, client.post("/calibrations", json={**SHORT, "name": "new"}).headers["location"], ended)
    name = job["result"]["calibration"]
    assert client.get("/platform").json()["calibration"]["id"] != name
    answer = client.post("/calibrations/adopt", json={"kind": "receive", "calibration": name})
    assert answer.status_code == 200
    assert answer.json()["calibration"]["id"] == name
    assert answer.json()["transmit_calibration"] is None
    assert client.get("/platform").json()["calibration"] == answer.json()["calibration"]


def test_nothing_is_adopted_while_a_calibration_waits_for_its_operator(client, monkeypatch):
    monkeypatch.setattr(client.engine.platform.reference, "turn", lambda axis: False)
    location = client.post("/calibrations", json=SHORT).headers["location"]
    until(client, location, lambda j: j["question"])
    answer = client.post("/calibrations/adopt", json={"kind": "transmit"})
    assert answer.status_code == 409
    client.delete(location)
    until(client, location, ended)


@pytest.mark.parametrize(
    "body",
    [
        {"kind": "both"},
        {"kind": "receive", "calibration": "../secret"},
        {"kind": "receive", "calibration": "a@9_20260101"},
    ],
)
def test_what_cannot_be_adopted_is_a_422_problem(client, body):
    before = client.get("/platform").json()["calibration"]
    answer = client.post("/calibrations/adopt", json=body)
    assert answer.status_code == 422
    assert answer.json()["remedy"]
    assert client.get("/platform").json()["calibration"] == before
