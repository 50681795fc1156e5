"""Jobs of all kinds in one list; who a caller is."""

import pytest

from platform_daemon.core.schemas.access import Role
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.rest import finished, problem


@pytest.fixture(scope="module")
def self_test_job(client):
    return finished(client, client.post("/self-tests", json={}).headers["location"])


def test_jobs_of_all_kinds_are_there_newest_first(client, recording, self_test_job):
    found = client.get("/jobs").json()["items"]
    assert [job["kind"] for job in found][:2] == ["self_test", "acquisition"]
    acquisition = found[1]
    assert acquisition["recording"] == recording
    assert acquisition["resonator"] == "jewel"
    assert acquisition["clock"] == client.get(acquisition["path"]).json()["clock"] == "simulated"
    assert client.get(f"/recordings/{recording}").json()["clock"] == "simulated"
    assert client.get("/recordings").json()["items"][0]["clock"] == "simulated"
    assert client.get(acquisition["path"]).json()["id"] == acquisition["id"]


def test_the_list_goes_on_after_its_last_one(client, recording, self_test_job):
    answer = client.get("/jobs", params={"limit": 1, "state": "done"})
    first = answer.json()
    assert first["next"].startswith("/jobs?state=done&limit=1&after=")
    assert answer.headers["link"] == f'<{first["next"]}>; rel="next"'
    second = client.get(first["next"]).json()
    assert second["items"][0]["id"] != first["items"][0]["id"]
    rest = client.get("/jobs", params={"limit": 200, "after": first["items"][0]["id"]}).json()
    assert rest["next"] is None
    assert first["items"][0]["id"] not in [job["id"] for job in rest["items"]]
    assert "after" in problem(client.get("/jobs", params={"after": "x"}), 422)["where"]


def test_jobs_are_filtered_by_how_they_ended_and_by_kind(client, self_test_job):
    cancelled = client.post("/acquisitions", json={**SHORT_JEWEL, "shots": 100}).json()["id"]
    client.delete(f"/acquisitions/{cancelled}")
    finished(client, f"/acquisitions/{cancelled}")
    found = client.get("/jobs", params={"state": "cancelled"}).json()["items"]
    assert [job["id"] for job in found] == [cancelled]
    found = client.get("/jobs", params={"kind": "self_test"}).json()["items"]
    assert [job["id"] for job in found] == [self_test_job["id"]]
    assert "one of" in problem(client.get("/jobs", params={"kind": "x"}), 422)["remedy"]


def test_a_caller_without_tokens_is_local(client):
    assert client.get("/caller").json() == {"name": "local", "role": "admin", "refused": None}


def test_a_caller_is_told_its_role_and_without_a_token_that_one_is_needed(secured):
    for role in Role:
        found = secured.client.get("/caller", headers=secured.headers[role]).json()
        assert found["role"] == role
    found = secured.client.get("/caller").json()
    assert found["role"] is None
    assert "token" in found["refused"]
