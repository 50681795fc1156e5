"""Campaigns over REST."""

import time

import pytest

from platform_daemon.features.reproduce.campaign import outcome_in
from tests.kit.rest import finished, problem

SHORT = {"shots": 2, "tune": False, "ramp": False}


@pytest.mark.long
def test_one_that_was_cancelled_is_resumed_and_measures_nothing_twice(client):
    answer = client.post("/reproductions", json={**SHORT, "thread": None, "jewel": "jewel"})
    assert answer.status_code == 202, answer.text
    here, folder = answer.headers["location"], client.folder.reproductions / answer.json()["id"]
    assert client.get(here).json()["links"]["pause"] == f"{here}/pause"
    problem(client.get(f"{here}/report"), 422)
    end_s = time.monotonic() + 300.0
    while not (folder / "jewel.h5.log.json").exists() or outcome_in(folder, "jewel") is None:
        assert time.monotonic() < end_s
        time.sleep(0.05)
    assert client.delete(here).status_code == 202
    job = finished(client, here)
    assert job["state"] == "cancelled"
    whole = (folder / "jewel.h5").stat().st_mtime_ns
    assert client.post(job["links"]["resume"], json={}).status_code == 202
    job = finished(client, here)
    assert job["state"] == "done", job["error"]
    assert (folder / "jewel.h5").stat().st_mtime_ns == whole
    claims = {claim["what"]: claim for claim in job["result"]["claims"]}
    assert claims["jewel: B_TX / uT"]["verdict"] == "agrees"
    assert "fig:noise_plot" in client.get(job["links"]["report"]).text
    problem(client.post(f"{here}/resume", json={}), 409)


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ({"thread": None, "jewel": None}, 422),
        ({"thread": "rope", "jewel": None}, 422),
        ({"jewel": "/etc/jewel.toml", "thread": None}, 422),
        ({"shots": 1}, 422),
    ],
)
def test_what_cannot_be_a_campaign_is_refused_at_once(client, body, status):
    problem(client.post("/reproductions", json=body), status)
