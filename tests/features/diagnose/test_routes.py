"""Diagnoses over REST, from the series to the adopted model in a later fit, with an effect that nobody declared."""

import h5py
import numpy as np
import pytest
from starlette.testclient import TestClient

from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.settings import load_platform
from platform_daemon.core.web.server import create_api
from platform_daemon.processes.assembly import start_engine
from tests.kit.linked_api import linked_context
from tests.kit.mmr_twins import SMALL, write_twin
from tests.kit.rest import finished
from tests.kit.specimen_files import pendulum, swing

SHOT = {"resonator": "thread", "sequence": {"rx_s": 1.0}}
FRICTION = 60.0


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = open_data_folder(tmp_path_factory.mktemp("data"))
    hidden = f'backends.simulated.undeclared=[{{id="coulomb_friction", strength={FRICTION}}}]'
    calm = [f"backends.simulated.effects.{e}.enabled=false" for e in ("temperature", "wear")]
    engine = start_engine(load_platform("simulated", [hidden, *calm]), JobRecords(folder.state), folder.models)
    with TestClient(
        create_api(linked_context(engine, folder)), raise_server_exceptions=False, base_url="http://127.0.0.1"
    ) as test_client:
        test_client.folder = folder
        yield test_client
    engine.close()


def measured(client, **keys):
    answer = client.post("/acquisitions", json={**SHOT, **keys})
    return finished(client, answer.headers["location"])["result"]["recording"]


@pytest.fixture(scope="module")
def recording(client):
    return measured(client, shots=3, blank_shots=1)


@pytest.fixture(scope="module")
def diagnosis(client, recording):
    answer = client.post("/diagnoses", json={"recordings": [recording]})
    assert answer.status_code == 202
    return finished(client, answer.headers["location"])


@pytest.mark.long
def test_the_effect_that_nobody_declared_is_named_with_its_strength(diagnosis, recording):
    assert diagnosis["state"] == "done", diagnosis["error"]
    assert diagnosis["progress"]["fraction"] == 1.0
    result = diagnosis["result"]
    assert result["verdict"] == "explained"
    (found,) = result["effects"]
    assert "coulomb_friction" in (found["id"], *found["indistinguishable_from"])
    assert result["held_out"]["chi2_per_dof_after"] < result["held_out"]["chi2_per_dof_before"]
    assert result["recordings"][0]["file"] == f"{recording}.h5"
    assert len(result["recordings"][0]["sha256"]) == 64


@pytest.mark.long
def test_the_report_is_a_page(client, diagnosis):
    page = client.get(diagnosis["links"]["report"])
    assert page.headers["content-type"].startswith("text/html")
    assert "coulomb_friction" in page.text
    assert (client.folder.diagnoses / f"{diagnosis['id']}.json").is_file()
    assert diagnosis["id"] in [d["id"] for d in client.get("/diagnoses").json()["items"]]


@pytest.mark.long
def test_an_adopted_model_explains_new_shots_and_every_result_names_it(client, diagnosis):
    answer = client.post(diagnosis["links"]["adopt"], json={"name": "dry", "by": "me"})
    assert answer.status_code == 201, answer.json()
    assert answer.headers["location"] == "/models/dry@1"
    evidence = client.get("/models/dry").json()["evidence"]
    assert evidence["adopted_by"] == "me"
    assert evidence["recordings"] == diagnosis["result"]["recordings"]
    new = measured(client, shots=2)
    before = finished(client, client.post("/fits", json={"recording": new}).headers["location"])
    after = finished(client, client.post("/fits", json={"recording": new, "variant": "dry"}).headers["location"])
    assert after["result"]["variant"] == "dry@1"
    # The friction makes the thread's lambda wrong by half: another variant says so, and the fit is refused.
    assert {f["reason"].partition(":")[0] for f in before["result"]["frames"]} == {"model_does_not_explain"}
    assert np.mean([f["chi2_per_dof"] for f in after["result"]["frames"]]) < 1.02
    assert client.get(f"/fits/{after['id']}/derived").status_code == 200
    online = client.post("/acquisitions", json={**SHOT, "variant": "dry@1"})
    assert finished(client, online.headers["location"])["result"]["fit"]["variant"] == "dry@1"


@pytest.mark.campaign
def test_a_diagnosis_that_starts_from_the_adopted_model_finds_nothing_more(client, diagnosis, recording):
    client.post(diagnosis["links"]["adopt"], json={"name": "base", "by": "me"})
    answer = client.post("/diagnoses", json={"recordings": [recording], "base": "base"})
    job = finished(client, answer.headers["location"])
    assert job["result"]["verdict"] == "nothing_missing", job
    refused = client.post(job["links"]["adopt"], json={"name": "more", "by": "me"})
    assert refused.status_code == 422
    assert refused.json()["type"] == "/problems/adoption-refused"
    assert refused.json()["remedy"]


@pytest.mark.long
def test_a_retired_model_is_listed_but_no_longer_meant_by_its_name(client, diagnosis, recording):
    client.post(diagnosis["links"]["adopt"], json={"name": "old", "by": "me"})
    assert client.post("/models/old@1/retire", json={"reason": "wrong"}).json()["retired"]["reason"] == "wrong"
    assert "old@1" in [m["label"] for m in client.get("/models").json()["items"]]
    assert client.get("/models/old").status_code == 404
    assert client.post("/fits", json={"recording": recording, "variant": "old"}).status_code == 422


@pytest.mark.campaign
def test_one_frame_is_split_in_time_and_says_so(client, recording):
    answer = client.post("/diagnoses", json={"recordings": [{"recording": recording, "frames": [1]}]})
    result = finished(client, answer.headers["location"])["result"]
    assert result["held_out"]["n_shots"] == 1
    assert any("one shot only" in note for note in result["notes"])


@pytest.mark.long
def test_a_diagnosis_under_way_can_be_cancelled(client, recording):
    answer = client.post("/diagnoses", json={"recordings": [recording]})
    here = answer.headers["location"]
    assert client.get(f"{here}/report").status_code == 422
    assert client.delete(here).status_code == 202
    assert finished(client, here)["state"] == "cancelled"


def damaged(client, recording, name, change):
    path = client.folder.recordings / f"{name}.h5"
    path.write_bytes((client.folder.recordings / f"{recording}.h5").read_bytes())
    with h5py.File(path, "r+") as file:
        change(file)
    return name


def angle(client, name, change):
    pendulum(client.folder.recordings, *change(*swing()), name=f"{name}.h5")
    return name


def volts(file):
    return file["data"] if isinstance(file["data"], h5py.Dataset) else file["data/data"]


def test_bad_requests_are_answered_at_once_with_problem_details(client, recording):
    flat = damaged(client, recording, "uncalibrated", lambda file: file.pop("calibration"))
    other = measured(client, resonator="jewel", sequence={"rx_s": 0.6})
    cases = [
        ({"recordings": []}, 422, "recordings"),
        ({"recordings": ["nowhere"]}, 404, "nowhere"),
        ({"recordings": [recording], "variant": "spring"}, 422, "spring"),
        ({"recordings": [recording], "base": "spring"}, 422, "spring"),
        ({"recordings": [recording], "observable": "colour"}, 422, "observable"),
        ({"recordings": [recording], "observable": "angle"}, 422, "/time"),
        ({"recordings": [{"recording": recording, "frames": [99]}]}, 422, "frame 99"),
        ({"recordings": [flat], "observable": "dmdt"}, 422, "sensitivity"),
        ({"recordings": [recording, other]}, 422, "different resonators"),
        ({"recordings": [angle(client, "back", lambda t, y: (t % t[t.size // 2], y))]}, 422, "runs back"),
        ({"recordings": [angle(client, "degrees", lambda t, y: (t, np.degrees(y)))]}, 422, "beyond pi"),
    ]
    for body, status, says in cases:
        answer = client.post("/diagnoses", json=body)
        assert answer.status_code == status, (body, answer.json())
        assert answer.headers["content-type"] == "application/problem+json"
        assert says in answer.json()["detail"] + answer.json().get("where", ""), answer.json()
        assert answer.json()["remedy"]


@pytest.mark.long
def test_volts_of_coils_without_a_calibration_are_diagnosed(client):
    write_twin(client.folder.recordings / "twin.h5", SMALL, frames=2, channels=2)
    answer = client.post("/diagnoses", json={"recordings": ["twin"], "variant": "thread"})
    job = finished(client, answer.headers["location"])
    assert job["state"] == "done", job["error"]
    assert job["result"]["verdict"] == "nothing_missing"
    assert any("two free sensitivities" in note for note in job["result"]["notes"])
    assert client.get(job["links"]["report"]).status_code == 200


@pytest.mark.parametrize("damage", ["noise", "nan"])
def test_shots_that_cannot_be_used_give_a_reason_and_no_ranking(client, recording, damage):
    def change(file):
        data = volts(file)
        bad = (
            np.random.default_rng(1).normal(0.0, 1e-2, data.shape) if damage == "noise" else np.full(data.shape, np.nan)
        )
        data[...] = bad

    name = damaged(client, recording, f"only-{damage}", change)
    job = finished(client, client.post("/diagnoses", json={"recordings": [name]}).headers["location"])
    assert job["state"] == "failed"
    assert job["result"] == {}
    assert job["error"]["type"] == "/problems/nothing-to-diagnose-error"
    assert job["error"]["remedy"]
    assert client.post(job["links"]["adopt"], json={"name": "x", "by": "me"}).status_code == 422


def test_an_angle_without_a_swing_says_what_was_seen(client):
    name = angle(client, "rest", lambda t, y: (t, 0.02 + 0.0 * y))
    job = finished(client, client.post("/diagnoses", json={"recordings": [name]}).headers["location"])
    assert job["state"] == "failed"
    assert "every sample is 0.02 rad: nothing moves" in job["error"]["detail"]
    assert "from its release on" in job["error"]["remedy"]
