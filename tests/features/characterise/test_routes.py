"""Characterisations over REST."""

import json

import pytest

from tests.kit.rest import finished, problem
from tests.kit.ring_down_series import jewels, write_ring_downs


@pytest.fixture(scope="module")
def job(client, recording):
    answer = client.post("/characterisations", json={"recording": recording})
    assert answer.status_code == 202
    return finished(client, answer.headers["location"])


@pytest.mark.long
def test_the_result_is_the_report_and_is_kept_on_disk(client, job, recording):
    assert job["state"] == "done", job["error"]
    assert job["progress"]["fraction"] == 1.0
    result = job["result"]
    assert result["file"] == f"{recording}.h5"
    assert (result["n50"]["good"], result["d30"]["good"]) == (2, 2)
    assert result["excitation"]["field_t"] > 0
    kept = json.loads((client.folder.characterisations / f"{job['id']}.json").read_text())
    assert kept == result
    assert job["id"] in [each["id"] for each in client.get("/characterisations").json()["items"]]


def test_the_smallest_level_has_intervals_too(client, recording):
    answer = client.post("/characterisations", json={"recording": recording, "alpha": 1e-12})
    done = finished(client, answer.headers["location"])
    assert done["state"] == "done", done["error"]


def test_the_page_can_be_read(client, job):
    page = client.get(job["links"]["report"])
    assert page.headers["content-type"].startswith("text/html")
    assert "N50 against D30" in page.text


def test_a_page_that_is_gone_is_not_found(client, recording):
    answer = client.post("/characterisations", json={"recording": recording, "frames": [0]})
    job = finished(client, answer.headers["location"])
    (client.folder.characterisations / f"{job['id']}.html").unlink()
    assert "characterise again" in problem(client.get(job["links"]["report"]), 404)["remedy"]


@pytest.mark.long
def test_one_under_way_can_be_cancelled_and_has_no_page(client):
    write_ring_downs(client.folder.recordings / "many.h5", jewels(12))
    here = client.post("/characterisations", json={"recording": "many"}).headers["location"]
    problem(client.get(f"{here}/report"), 422)
    assert client.delete(here).status_code == 202
    assert finished(client, here)["state"] == "cancelled"


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ({"recording": "nothing"}, 404),
        ({"recording": "{recording}", "frames": [99]}, 422),
        ({"recording": "{recording}", "held_in_n50": {"m_r_am2": 1.0}}, 422),
        ({"recording": "{recording}", "alpha": 0.0}, 422),
        ({"recording": "{recording}", "alpha": 0.99e-12}, 422),
        ({"recording": "{recording}", "variant": "rope"}, 422),
        ({}, 422),
    ],
)
def test_what_cannot_be_characterised_is_refused_at_once(client, recording, body, status):
    asked = json.loads(json.dumps(body).replace("{recording}", recording))
    problem(client.post("/characterisations", json=asked), status)


@pytest.mark.long
def test_shots_that_are_all_refused_are_a_result_with_a_warning(client):
    write_ring_downs(client.folder.recordings / "none.h5", [None, None])
    answer = client.post("/characterisations", json={"recording": "none"})
    job = finished(client, answer.headers["location"])
    assert (job["state"], job["result"]["d30"]["good"]) == ("done", 0)
    assert job["warnings"] == ["every shot was refused in both windows"]
