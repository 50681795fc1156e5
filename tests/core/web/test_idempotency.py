"""A POST that is repeated with its idempotency key starts nothing twice."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from platform_daemon.core.schemas.requests import CalibrationRequest
from platform_daemon.core.service.submit_once import IdempotencyKeyReused
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.rest import finished

REQUEST = {**SHORT_JEWEL, "shots": 1}


def post(client, path, body, key):
    return client.post(path, json=body, headers={"Idempotency-Key": key})


def test_a_repeated_request_returns_the_first_job_whatever_became_of_it(client):
    first = post(client, "/acquisitions", REQUEST, "one")
    again = post(client, "/acquisitions", REQUEST, "one")
    assert (first.status_code, again.status_code) == (202, 202)
    assert first.headers["location"] == again.headers["location"]
    finished(client, first.headers["location"])
    late = post(client, "/acquisitions", REQUEST, "one").json()
    assert (late["id"], late["state"]) == (first.json()["id"], "done")
    assert post(client, "/acquisitions", REQUEST, "two").json()["id"] != late["id"]
    client.delete("/acquisitions/" + late["id"])


def test_of_many_at_the_same_time_one_starts_a_job(client):
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: post(client, "/acquisitions", REQUEST, "crowd"), range(8)))
    assert {answer.status_code for answer in answers} == {202}
    assert len({answer.json()["id"] for answer in answers}) == 1


def test_the_key_of_another_request_is_refused_with_the_job_that_has_it(client):
    first = post(client, "/acquisitions", REQUEST, "mine").json()["id"]
    refused = post(client, "/acquisitions", {**REQUEST, "shots": 2}, "mine")
    assert refused.status_code == 422
    assert refused.json()["type"] == "/problems/idempotency-key-reused"
    assert first in refused.json()["detail"]
    assert "new key" in refused.json()["remedy"]
    assert client.get(refused.json()["type"]).status_code == 200


@pytest.mark.parametrize("key", ["", "x" * 201], ids=["empty", "too long"])
def test_a_key_that_is_none_is_refused(client, key):
    assert post(client, "/acquisitions", REQUEST, key).status_code == 422


def test_a_fit_has_keys_as_well(client, recording):
    body = {"recording": recording}
    first, again = (post(client, "/fits", body, "one") for _ in range(2))
    assert first.json()["id"] == again.json()["id"]
    assert post(client, "/fits", {**body, "window": "n50"}, "one").status_code == 422


def test_a_repeated_request_returns_the_first_job_after_a_restart(tmp_path, linked_in):
    request = CalibrationRequest(kind="transmit", frequencies_hz=(100.0, 212.0))
    identifiers = []
    for _ in range(2):
        made = linked_in(tmp_path)
        identifiers.append(made.remote.submit_once("calibration", request, "night").identifier)
        with pytest.raises(IdempotencyKeyReused, match=identifiers[0]):
            made.remote.submit_once("calibration", CalibrationRequest(kind="receive"), "night")
        assert len(made.remote.job_ids("calibration")) == 1
        made.remote.close()
        made.server.close()
        made.engine.close()
        made.data.lock.close()
    assert identifiers[0] == identifiers[1]


def test_a_refused_request_does_not_use_up_its_key(client):
    body = {**REQUEST, "resonator": "nothing-of-that-name"}
    for _ in range(2):
        assert post(client, "/acquisitions", body, "refused").status_code == 422
    assert post(client, "/acquisitions", REQUEST, "refused").status_code == 202
