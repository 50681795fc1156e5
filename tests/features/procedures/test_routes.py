"""Procedures by REST: asked for, watched step by step, paused, resumed, cancelled; what cannot be is a problem."""

import json
import time

import pytest

from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.kinds import job_type
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.service.job_view import JobView
from platform_daemon.features.procedures.routes import PROCEDURES
from platform_daemon.features.procedures.schema import ProcedureLog, ProcedureSummary
from tests.kit.rest import finished, problem
from tests.kit.sweeps import sweep_request

TUNE = {"kind": "tune", "acquisition": {"resonator": "jewel"}, "keep": False}
WINDOWED = {"sequence": {"rx_s": 0.3}, "window": "n50"}


def until(client, location, condition):
    deadline = time.monotonic() + 60
    while not condition(job := client.get(location).json()):
        assert time.monotonic() < deadline, job
        time.sleep(0.01)
    return job


@pytest.mark.long
def test_a_sweep_is_planned_accepted_and_ends_with_typed_steps_and_one_recording(client):
    body = sweep_request(**WINDOWED)
    plan = client.post("/procedures/dry-run", json=body).json()
    assert [(s["step"], s["values"], s["shots"]) for s in plan["steps"]][2] == (
        3,
        [{"key": "field_ut", "value": 400}],
        1,
    )
    answer = client.post("/procedures", json=body)
    assert answer.status_code == 202
    job = finished(client, answer.headers["location"])
    assert (job["kind"], job["state"], job["paused"]) == ("procedure", "done", False)
    assert job["progress"]["done"] == plan["shots"] == 3
    steps = job["result"]["steps"]
    swing = [s["results"]["phi_max_rad"]["median"] for s in steps]
    assert swing == sorted(swing)
    assert {s["verdict"] for s in steps} == {"good"}
    recording = client.get(job["links"]["recording"]).json()
    assert recording["id"] == job["id"]
    assert [(f["step"], f["values"]) for f in recording["shots"]] == [
        (s["step"], {"field_ut": s["values"][0]["value"]}) for s in steps
    ]
    assert client.get(f"/acquisitions/{steps[0]['acquisitions'][0]}").json()["result"]["recording"] == job["id"]
    assert [j["id"] for j in client.get("/procedures").json()["items"]] == [job["id"]]
    log = json.loads((client.folder.procedures / f"{job['id']}.json").read_text())
    assert log["result"] == job["result"]
    # A fit of the recording, of every step or of the last one, which it names.
    asked = {"recording": job["id"], "window": "n50"}
    fit = finished(client, client.post("/fits", json={**asked, "step": "all"}).headers["location"])
    found = [f["parameters"]["phi_max_rad"]["value"] for f in fit["result"]["frames"]]
    assert found == pytest.approx(swing, rel=1e-4)
    last = finished(client, client.post("/fits", json=asked).headers["location"])
    assert [f["frame"] for f in last["result"]["frames"]] == [2]
    assert "step 3 (sweep, field_ut = 400) of 3 is taken" in " ".join(last["result"]["notes"])
    assert {s["quantity"]: s["source"] for s in steps[0]["value_sources"]}["field_t"] == "given"
    # The id answers after a restart.
    kept = next(j for j in JobRecords(client.folder.state).load() if j.identifier == job["id"])
    assert PROCEDURES.shown(JobView.of(kept)).result.model_dump(mode="json") == job["result"]


@pytest.mark.long
def test_it_is_paused_resumed_and_cancelled(client):
    location = client.post("/procedures", json=sweep_request(shots=50)).headers["location"]
    until(client, location, lambda job: job["progress"]["done"] > 1)
    paused = client.post(f"{location}/pause", json={})
    assert (paused.status_code, paused.json()["paused"]) == (202, True)
    job = until(client, location, lambda job: job["progress"]["phase"] == "paused")
    assert job["progress"]["time_left_s"] is None
    assert "resume" in job["links"]
    assert client.get("/platform").json()["running"] is None
    resumed = client.post(f"{location}/resume", json={})
    assert (resumed.status_code, resumed.json()["paused"]) == (202, False)
    further = until(client, location, lambda now: now["progress"]["done"] > job["progress"]["done"])
    assert "pause" in further["links"]
    assert client.delete(location).status_code == 202
    job = finished(client, location)
    assert job["state"] == "cancelled"
    assert job["result"]["stopped"] == "cancelled"
    assert client.get(f"/recordings/{job['id']}").json()["incomplete"] == "stopped after 0 of 3 steps: cancelled"
    for what in ("pause", "resume"):
        body = problem(client.post(f"{location}/{what}", json={}), 409)
        assert body["detail"].startswith(f"{job['id']}: the procedure has ended")


@pytest.mark.parametrize(
    ("over", "words"),
    [
        ({"key": "field", "values": [1]}, ("no key", "sequence.field_t")),
        ({"key": "field_ut", "start": 1, "stop": 2, "step": 0}, ("over.0", "step of 0")),
        ({"key": "field_ut", "start": 1, "stop": 300, "step": -1}, ("over.0", "change the sign")),
        ({"key": "field_ut", "start": 1, "stop": 2, "step": 1e-9}, ("over.0", "1000 steps")),
        ({"key": "field_ut", "start": 1, "stop": 2}, ("over.0", "start, stop and step")),
        ({"key": "field_ut", "values": [10**400]}, ("over.0.values.0",)),
        ({"key": "field_ut", "values": []}, ("over.0.values",)),
        ({"key": "field_ut", "values": [100, 1e9]}, ("step 2 (field_ut = 1000000000.0)", "sequence.field_t")),
    ],
)
@pytest.mark.parametrize("path", ["/procedures", "/procedures/dry-run"])
def test_what_cannot_be_swept_is_a_problem_with_its_place_and_a_remedy(client, path, over, words):
    before = len(client.get("/procedures").json()["items"])
    body = problem(client.post(path, json=sweep_request(over)), 422)
    for word in words:
        assert word in body["detail"]
    assert body["remedy"]
    assert len(client.get("/procedures").json()["items"]) == before


def test_too_many_combinations_and_a_resonator_by_its_path_are_refused(client):
    many = [
        {"key": "field_ut", "start": 1, "stop": 100, "step": 1},
        {"key": "rx_ms", "start": 1, "stop": 100, "step": 1},
    ]
    assert "10000 steps" in problem(client.post("/procedures", json=sweep_request(*many)), 422)["detail"]
    path = sweep_request(resonator="/etc/jewel.toml")
    assert "no resonator" in problem(client.post("/procedures", json=path), 422)["detail"]
    assert problem(client.get("/procedures/x"), 404)["where"] == "x"


@pytest.mark.parametrize("model", [ProcedureLog, ProcedureSummary, job_type("procedure")], ids=lambda m: m.__name__)
def test_the_examples_are_what_they_are_examples_of(model):
    for example in model.model_json_schema(mode="serialization")["examples"]:
        assert json.loads(to_json(model.model_validate_json(json.dumps(example)))) == example


def test_a_characterisation_ends_with_tables_and_a_page(client):
    shots = {"resonator": "jewel", "shots": 2, "sequence": {"rx_s": 0.6, "pause_s": 5.0}}
    body = {"kind": "characterise", "acquisition": shots}
    assert client.post("/procedures/dry-run", json=body).json()["shots"] == 2
    here = client.post("/procedures", json=body).headers["location"]
    problem(client.get(f"{here}/report"), 422)
    job = finished(client, here)
    assert job["state"] == "done", job["error"]
    result = job["result"]["outcome"]["report"]
    assert (result["d30"]["good"], result["n50"]["good"]) == (2, 2)
    page = client.get(job["links"]["report"])
    assert page.headers["content-type"].startswith("text/html")
    assert json.loads((client.folder.characterisations / f"{job['id']}.json").read_text()) == result
    held = {**body, "held_in_n50": {"m_r_am2": 1.0}}
    assert "no loss" in problem(client.post("/procedures", json=held), 422)["detail"]


def test_tune_is_a_procedure_like_any_other_with_its_outcome_in_the_result(client):
    plan = client.post("/procedures/dry-run", json=TUNE).json()
    assert plan["shots"] == len(plan["steps"]) == 5
    job = finished(client, client.post("/procedures", json=TUNE).headers["location"])
    assert job["state"] == "done", job["error"]
    found = job["result"]["outcome"]
    assert found["f_nat_hz"]["value"] == pytest.approx(213.25, abs=0.5)
    assert found["shots"] == len(job["result"]["steps"]) <= 5
    assert "preset" not in found
    kept = next(j for j in JobRecords(client.folder.state).load() if j.identifier == job["id"])
    assert PROCEDURES.shown(JobView.of(kept)).result.model_dump(mode="json") == job["result"]


@pytest.mark.parametrize(
    ("body", "word"),
    [
        ({**TUNE, "kind": "tun"}, "kind"),
        ({**TUNE, "acquisition": {"resonator": "jewel", "shots": 2}}, "shots"),
        ({**TUNE, "acquisition": {"resonator": "jewel", "window": None}}, "window"),
        ({**TUNE, "over": []}, "over"),
    ],
)
def test_a_tune_that_cannot_be_is_a_problem(client, body, word):
    answer = client.post("/procedures", json=body)
    assert answer.status_code == 422
    assert word in answer.text
