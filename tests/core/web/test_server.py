import io
import json
import shutil
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np
import pytest
from starlette.testclient import TestClient

from platform_daemon.core.recordings.assembly import header_of
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.settings import load_platform
from platform_daemon.core.web.server import create_api
from platform_daemon.processes.assembly import start_engine
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.data import DATA
from tests.kit.linked_api import linked_context
from tests.kit.rest import finished, problem


def test_an_acquisition_is_accepted_with_a_location_and_ends_with_fits(client):
    answer = client.post("/acquisitions", json=SHORT_JEWEL)
    assert answer.status_code == 202
    assert answer.json()["state"] in ("queued", "running")
    job = finished(client, answer.headers["location"])
    assert job["state"] == "done"
    assert job["progress"] == {
        "done": 1.0, "total": 1.0, "unit": "shots", "phase": "done", "fraction": 1.0, "time_left_s": 0.0
    }  # fmt: skip
    assert job["result"]["fit"]["frames"][0]["verdict"] == "good"
    assert client.get(job["links"]["recording"]).json()["variant"] == "jewel"


def test_a_second_acquisition_waits_in_the_queue_and_can_be_taken_out(client):
    first = client.post("/acquisitions", json={**SHORT_JEWEL, "shots": 20})
    second = client.post("/acquisitions", json=SHORT_JEWEL)
    assert second.json()["state"] == "queued"
    assert client.delete(second.headers["location"]).json()["state"] == "cancelled"
    assert client.delete(first.headers["location"]).status_code == 202
    job = finished(client, first.headers["location"])
    assert job["state"] == "cancelled"
    assert 0 <= job["result"].get("shots", 0) < 20


def test_others_are_answered_while_the_disk_takes_its_time_over_a_cancelled_job(client):
    locations = [client.post("/acquisitions", json={**SHORT_JEWEL, "shots": 20}).headers["location"] for _ in "12"]
    writes, written = threading.Event(), threading.Event()

    def slowly(job):
        writes.set()
        written.wait(20)

    client.engine.job("acquisition", locations[1].rsplit("/", 1)[1]).on_change = slowly
    with ThreadPoolExecutor(2) as clients:
        cancelling = clients.submit(client.delete, locations[1])
        try:
            assert writes.wait(20)
            assert clients.submit(client.get, "/health").result(timeout=10).status_code == 200
            assert not cancelling.done()
        finally:
            written.set()
        assert cancelling.result(timeout=20).json()["state"] == "cancelled"
    client.delete(locations[0])
    assert finished(client, locations[0])["state"] == "cancelled"


def test_stop_cancels_everything_and_the_platform_says_outputs_are_off(client):
    answer = client.post("/acquisitions", json={**SHORT_JEWEL, "shots": 200})
    assert client.post("/stop").status_code == 200
    assert finished(client, answer.headers["location"])["state"] == "cancelled"
    state = client.get("/platform").json()
    assert not state["power_amplifier"]["enabled"]
    assert state["tx_rx_switch"]["position"] == "transmit"


def test_a_latched_trip_is_cleared_by_its_own_command(client):
    world = client.engine.platform.backends["simulated"].world
    world.trip_amplifier()
    failed = finished(client, client.post("/acquisitions", json=SHORT_JEWEL).headers["location"])
    assert failed["error"]["type"] == "/problems/device-fault"
    assert "reset" in failed["error"]["remedy"]
    answer = client.post("/devices/power_amplifier/reset", json={})
    assert answer.status_code == 200
    assert answer.json()["fault"] == "over-current"
    assert answer.json()["power_amplifier"]["fault"] is None
    assert client.get("/platform").json()["power_amplifier"]["fault"] is None
    assert finished(client, client.post("/acquisitions", json=SHORT_JEWEL).headers["location"])["state"] == "done"


def test_a_fault_is_not_cleared_under_a_running_series(client):
    location = client.post("/acquisitions", json={**SHORT_JEWEL, "shots": 1000}).headers["location"]
    while client.get(location).json()["state"] == "queued":
        time.sleep(0.01)
    answer = client.post("/devices/power_amplifier/reset", json={})
    assert answer.status_code == 409
    assert answer.json()["where"] == "power_amplifier"
    client.delete(location)
    assert finished(client, location)["state"] == "cancelled"


def test_a_dry_run_says_what_would_happen_and_moves_nothing(client):
    before = len(client.get("/acquisitions").json()["items"])
    plan = client.post("/acquisitions/dry-run", json={"resonator": "thread", "shots": 100}).json()
    assert plan["shot"]["f_tx_realised_hz"] == pytest.approx(212.00124, abs=1e-5)
    assert plan["duration_s"] == pytest.approx(100 * 15.06, rel=1e-3)
    assert plan["settle"]["share"] == pytest.approx(0.0247, abs=2e-4)
    assert len(client.get("/acquisitions").json()["items"]) == before


def test_dmdt_comes_decimated_as_json_and_in_full_as_npy_and_h5(client, recording):
    base = f"/recordings/{recording}/frames/1/dmdt"
    points = client.get(base, params={"points": 500}).json()
    full = np.load(io.BytesIO(client.get(base, params={"format": "npy"}).content))
    assert points["unit"] == "A m^2/s"
    assert full.shape == (3, points["samples"])
    assert len(points["t_s"]) <= 500
    assert max(points["maximum"][0]) == full[0].max()
    assert min(points["minimum"][2]) == full[2].min()
    with h5py.File(io.BytesIO(client.get(base, params={"format": "h5"}).content)) as file:
        np.testing.assert_array_equal(file["dmdt"], full)
        assert file["dmdt"].attrs["units"] == "A m^2/s"
        assert file["time"][0] == 0.0


def test_dmdt_of_a_series_that_runs_says_which_shot_of_which_recording_it_is(client, recording):
    target = client.folder.recordings / "runs.h5"
    shutil.copy(client.folder.recordings / f"{recording}.h5", target)
    with SeriesWriter.go_on(target, header_of(open_recording(target))[0]) as series:
        target.unlink()
        answer = client.get("/recordings/runs/frames/1/dmdt", params={"format": "h5"})
        series.drop()
    assert answer.status_code == 200, answer.text
    with h5py.File(io.BytesIO(answer.content)) as file:
        assert [file.attrs[name] for name in ("recording", "file", "frame", "shot")] == ["runs", "runs.h5", 1, 2]


def test_dmdt_is_minus_the_inverse_of_the_sensitivity_times_the_volts(client, recording):
    stored = open_recording(client.folder.recordings / f"{recording}.h5")
    full = np.load(io.BytesIO(client.get(f"/recordings/{recording}/frames/0/dmdt?format=npy").content))
    if stored.calibration.frequency_response is None:
        expected = -np.linalg.inv(stored.calibration.sensitivity) @ stored.rx_volts(0)
        np.testing.assert_allclose(full, expected, rtol=1e-9, atol=1e-12)
    assert np.abs(full[0]).max() > 5 * np.abs(full[2]).std()


def test_a_cut_of_dmdt_starts_where_asked(client, recording):
    cut = client.get(f"/recordings/{recording}/frames/0/dmdt", params={"start_s": 0.1, "stop_s": 0.11}).json()
    assert cut["t_s"][0] == pytest.approx(0.1, abs=1e-5)
    assert cut["samples"] == pytest.approx(610, abs=1)


@pytest.mark.parametrize("span", [{"start_s": 5.0}, {"stop_s": 5.0}, {"start_s": 0.2, "stop_s": 0.1}])
def test_a_time_range_outside_the_frame_is_a_problem_not_a_clamp(client, recording, span):
    answer = client.get(f"/recordings/{recording}/frames/0/dmdt", params=span)
    assert "from 0 to 0.599998 s" in problem(answer, 422)["remedy"]


def test_resonators_are_listed_with_their_preset_sequences(client):
    found = {each["id"]: each for each in client.get("/resonators").json()["items"]}
    assert set(found) == {f"{v}{end}" for v in ("jewel", "thread") for end in ("", "_imperfect", "_published")}
    assert found["thread"]["sequence"]["rx_s"] == 15.0


def test_a_fit_job_gives_the_fixed_form_and_is_kept_on_disk(client, recording):
    answer = client.post("/fits", json={"recording": recording, "window": 0.3})
    assert answer.status_code == 202
    job = finished(client, answer.headers["location"])
    assert job["result"]["window_s"] == pytest.approx(0.3, abs=1e-3)
    frame = job["result"]["frames"][0]
    assert frame["verdict"] == "good", frame
    assert {"value", "std"} == set(frame["parameters"]["f_nat_hz"])
    assert (client.folder.fits / f"{job['id']}.json").is_file()


def test_the_recording_can_be_downloaded_whole(client, recording):
    answer = client.get(f"/recordings/{recording}/file")
    assert answer.content == (client.folder.recordings / f"{recording}.h5").read_bytes()


def test_a_broken_file_in_the_folder_is_listed_with_its_defect(client):
    (client.folder.recordings / "broken.h5").write_bytes(b"no hdf5")
    listing = client.get("/recordings").json()
    assert [b["id"] for b in listing["broken"]] == ["broken"]
    assert listing["broken"][0]["error"]["remedy"]
    assert client.get("/recordings/broken").status_code == 422


@pytest.mark.parametrize(
    "path",
    [
        "/acquisitions/nothing",
        "/fits/nothing",
        "/recordings/nothing",
        "/recordings/nothing/file",
        "/recordings/nothing/frames/0/dmdt",
        "/recordings/..%2F..%2Fetc%2Fpasswd",
        "/nothing",
        "/problems/nothing",
    ],
)
def test_an_unknown_id_is_a_404_problem_with_a_remedy(client, path):
    assert problem(client.get(path), 404)["remedy"]


@pytest.mark.parametrize(
    ("body", "place"),
    [
        ({"resonator": "spring"}, "spring"),
        ({"resonator": "/etc/passwd"}, "resonator"),
        ({"resonator": "jewel.toml"}, "resonator"),
        ({"resonator": "jewel", "sequence": {"repetitions": 9}}, "repetitions"),
        ({"resonator": "jewel", "sequence": {"axis": [1e200, 1e200, 0]}}, "axis"),
        ({"resonator": "jewel", "shots": -1}, "shots"),
        ({"resonator": "jewel", "shots": "3"}, "shots"),
        ({"resonator": "jewel", "shots": 0}, "shots"),
        ({"resonator": "jewel", "shot": 3}, "shot"),
        ({}, "resonator"),
        ({"resonator": "jewel", "window": "d40"}, "window"),
        ({"resonator": "jewel", "window": -1}, "window"),
        ({"resonator": "jewel", "sequence": {"rx_s": 0}}, "rx_s"),
        ({"resonator": "jewel", "sequence": {"field_t": 5e-3}}, "field_t"),
        ({"resonator": "jewel", "sequence": {"field_t": "490 uT"}}, "field_t"),
        ({"resonator": "jewel", "sequence": {"field_ut": 490}}, "field_ut"),
        ({"resonator": "jewel", "sequence": {"switch_s": 0.001}}, "switch_s"),
    ],
)
def test_a_bad_request_is_a_422_problem_that_names_the_place(client, body, place):
    before = len(client.get("/acquisitions").json()["items"])
    found = problem(client.post("/acquisitions", json=body), 422)
    assert place in found["detail"]
    assert found["remedy"]
    assert len(client.get("/acquisitions").json()["items"]) == before


@pytest.mark.parametrize(
    "body",
    [
        {"recording": "nothing"},
        {"recording": "../x"},
        {"recording": "nothing", "window": "x"},
        {"recording": "nothing", "variant": "spring"},
    ],
)
def test_a_fit_of_nothing_is_a_problem(client, body):
    answer = client.post("/fits", json=body)
    problem(answer, answer.status_code)
    assert answer.status_code in (404, 422)


def test_a_parameter_that_cannot_be_held_is_refused_before_the_job(client, recording):
    found = problem(client.post("/fits", json={"recording": recording, "fixed": {"rodrigues_x": 1.0}}), 422)
    assert "rodrigues_x" in found["detail"]
    found = problem(client.post("/fits", json={"recording": recording, "hints": {"f_nat_hz": 213.0}}), 422)
    assert "f_nat_hz" in found["detail"]


def test_a_frame_that_does_not_exist_is_a_problem(client, recording):
    assert "frame" in problem(client.get(f"/recordings/{recording}/frames/9/dmdt"), 422)["detail"]


def test_text_that_is_no_json_is_a_problem(client):
    problem(client.post("/acquisitions", content=b"{", headers={"content-type": "application/json"}), 422)


def test_every_problem_type_has_a_page(client):
    found = problem(client.post("/acquisitions", json={"resonator": "spring"}), 422)
    page = client.get(found["type"]).json()
    assert page["title"] == found["title"]
    assert page["meaning"]


def test_ready_becomes_true_once_everything_has_warmed_up(client):
    deadline = time.monotonic() + 120
    while client.get("/ready").status_code == 503 and time.monotonic() < deadline:
        time.sleep(0.1)
    expected = {"ready": True, "warm": {"platform": True, "estimator": True}, "waiting_for": {}}
    assert client.get("/ready").json() == expected


def test_openapi_shows_examples_and_problem_details(client):
    schema = client.get("/openapi.json").json()
    assert schema["components"]["schemas"]["AcquisitionRequest"]["examples"]
    responses = schema["paths"]["/acquisitions"]["post"]["responses"]
    assert "202" in responses
    assert responses["422"]["content"]["application/problem+json"]["schema"]["$ref"].endswith("/Problem")


def test_methods_that_a_path_has_not_are_a_problem_that_names_those_it_has(client):
    answer = client.put("/fits")
    assert problem(answer, 405)["remedy"] == "use GET, HEAD, POST"
    assert answer.headers["allow"] == "GET, HEAD, POST"
    assert client.get("/calibrations/adopt").status_code == 404
    assert client.request("OPTIONS", "/calibrations/adopt").headers["allow"] == "POST"


@pytest.mark.parametrize("headers", [{"content-type": "application/x-www-form-urlencoded"}, {}])
def test_a_body_that_is_not_said_to_be_json_is_refused_with_the_header_that_is_missing(client, headers):
    answer = client.post("/acquisitions", content=b'{"resonator": "jewel"}', headers=headers)
    assert "-H 'Content-Type: application/json'" in problem(answer, 415)["remedy"]


@pytest.mark.parametrize("content", [b"{", b"\xff\xfe", b'{"resonator": "\\ud800"}', b'{"\\ud800": 1}', b"[" * 10_000])
def test_bytes_that_are_no_request_are_a_problem(client, content):
    problem(client.post("/acquisitions", content=content, headers={"content-type": "application/json"}), 422)


def test_every_operation_declares_its_problems_and_binary_answers_as_what_they_are(client):
    paths = client.get("/openapi.json").json()["paths"]
    operations = [operation for item in paths.values() for operation in item.values()]
    assert len({o["operationId"] for o in operations}) == len(operations)
    for operation in operations:
        assert operation["summary"]
        assert operation["description"]
        for status, response in operation["responses"].items():
            if int(status) >= 400 and operation["operationId"] != "get_readiness":
                assert list(response["content"]) == ["application/problem+json"], operation["operationId"]
    content = {o["operationId"]: o["responses"].get("200", {}).get("content", {}) for o in operations}
    binary = {"schema": {"type": "string", "format": "binary"}}
    assert content["download_recording"] == {"application/x-hdf5": binary}
    assert content["get_dmdt_npy"] == content["get_dmdt_h5"] == {"application/octet-stream": binary}
    assert content["get_dmdt"]["application/octet-stream"] == binary
    assert content["draw_defects"] == {"image/png": binary}
    assert list(content["get_report"]) == ["text/html"]


def test_a_daemon_that_shuts_down_takes_no_work_and_says_so(tmp_path):
    folder = open_data_folder(tmp_path)
    shutil.copyfile(DATA / "example_jewel.mmr.h5", folder.recordings / "ours.h5")
    engine = start_engine(load_platform("simulated"))
    context = linked_context(engine, folder)
    with TestClient(create_api(context), raise_server_exceptions=False, base_url="http://127.0.0.1") as stopping:
        engine.close()
        context.analyses.close()
        asked = {
            "/acquisitions": SHORT_JEWEL,
            "/calibrations": {"kind": "transmit"},
            "/fits": {"recording": "ours"},
            "/diagnoses": {"recordings": ["ours"]},
        }
        for path, body in asked.items():
            told = problem(stopping.post(path, json=body), 503)
            assert (told["type"], "start it again" in told["remedy"]) == ("/problems/shutting-down", True)
        schema = stopping.get("/openapi.json").json()
        for path in asked:
            assert "application/problem+json" in schema["paths"][path]["post"]["responses"]["503"]["content"]
        ready = schema["paths"]["/ready"]["get"]["responses"]["503"]["content"]["application/json"]
        assert ready["schema"]["$ref"].endswith("/Readiness")


def test_every_field_of_every_schema_says_what_it_is_and_every_answer_has_an_example(client):
    schema = client.get("/openapi.json").json()
    parts = schema["components"]["schemas"]
    silent = [
        f"{name}.{key}"
        for name, part in parts.items()
        for key, field in part.get("properties", {}).items()
        if not (field.get("description") or parts[field["$ref"].rsplit("/", 1)[1]].get("description"))
    ]
    assert not silent
    for path, item in schema["paths"].items():
        for method, operation in item.items():
            for status, response in operation["responses"].items():
                content = response.get("content", {}).get("application/json")
                if content is not None:
                    told = parts.get(content["schema"].get("$ref", "").rsplit("/", 1)[-1], {})
                    assert "example" in content or "examples" in told, (method, path, status)


def test_no_schema_is_there_twice(client):
    names = client.get("/openapi.json").json()["components"]["schemas"]
    assert not [name for name in names if name.endswith(("-Input", "-Output", "ValidationError"))]


def test_of_a_body_of_which_all_is_wrong_so_much_is_explained_as_takes_no_time(client):
    body = {f"k{number}": 1 for number in range(50_000)}
    told = problem(client.post("/acquisitions/dry-run", json=body), 422)
    assert "key 'k0' is unknown" in told["detail"]
    assert "49801 other complaints were not looked at" in told["detail"]


def test_the_schema_is_written_once(client, monkeypatch):
    before = client.get("/openapi.json")
    monkeypatch.setattr(json, "dumps", None)
    again = client.get("/openapi.json")
    assert again.content == before.content
    assert again.headers["content-type"] == "application/json"
