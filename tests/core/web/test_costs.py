"""Requests that are valid, and would take more than one request may: refused with the bound and the remedy."""

import pytest

from platform_daemon.core.web import costs
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.rest import pages, problem


@pytest.mark.parametrize(
    "plan",
    [
        {"sampling_rate_hz": 1e9, "expected": {"f_nat_hz": 1e5}, "windows": [100.0]},
        {"sampling_rate_hz": 1e300, "expected": {"f_nat_hz": 1e6}, "windows": ["n50", 5.0, 100.0]},
    ],
)
def test_a_prediction_over_gigabytes_of_samples_is_refused_before_it_holds_them(client, plan):
    asked = {"resonator": "jewel", "phi_max_rad": 0.7, **plan}
    found = problem(client.post("/predict", json=asked), 422)
    assert "at most 4000000 are computed" in found["detail"]


def test_sliding_windows_are_bounded_by_their_number_and_by_what_they_hold(client, recording, monkeypatch):
    path = f"/recordings/{recording}/frames/0/sliding"
    many = problem(client.get(path, params={"window_s": 0.2, "step_s": 1e-4}), 422)
    assert "windows of 12207 samples; at most 500 windows" in many["detail"]
    monkeypatch.setattr("platform_daemon.features.fit.stored_frame_routes.MOST_SLIDING_SAMPLES", 100_000)
    assert "100000 samples" in problem(client.get(path, params={"window_s": 0.3, "step_s": 0.01}), 422)["detail"]
    assert client.get(path, params={"window_s": 0.2, "step_s": 0.2}).status_code == 200


@pytest.mark.parametrize("what", ["dmdt", "dmdt.npy", "dmdt.h5", "sliding?window_s=0.2", "harmonics"])
def test_a_frame_that_is_too_long_to_be_read_while_somebody_waits_is_refused(client, recording, what, monkeypatch):
    monkeypatch.setattr(costs, "MOST_FRAME_VALUES", 1000)
    found = problem(client.get(f"/recordings/{recording}/frames/0/{what}"), 422)
    assert found["type"] == "/problems/too-costly"
    assert "at most 1000" in found["detail"]
    assert client.get(found["type"]).json()["meaning"]
    assert client.get(f"/recordings/{recording}/file").status_code == 200


@pytest.mark.parametrize("what", ["dmdt.npy?", "dmdt.h5?", "dmdt?format=npy&", "dmdt?format=h5&"])
def test_a_part_is_sent_in_full_only_if_it_is_short_enough(client, recording, what, monkeypatch):
    monkeypatch.setattr(costs, "MOST_SENT_VALUES", 10_000)
    path = f"/recordings/{recording}/frames/0/{what}"
    assert "start_s and stop_s" in problem(client.get(path), 422)["remedy"]
    assert client.get(f"{path}start_s=0.1&stop_s=0.11").status_code == 200


def test_more_points_than_a_plot_can_show_are_refused(client, recording):
    assert client.get(f"/recordings/{recording}/frames/0/dmdt?points=20000").status_code == 200
    problem(client.get(f"/recordings/{recording}/frames/0/dmdt?points=20001"), 422)


def test_jobs_come_page_by_page_in_the_order_in_which_they_were_asked_for(client):
    made = [client.post("/acquisitions", json={**SHORT_JEWEL, "shots": 50}).json()["id"] for _ in range(5)]
    client.post("/stop")
    whole = [job["id"] for job in client.get("/acquisitions").json()["items"]]
    assert whole[-5:] == made
    pages_of_two = list(pages(client, "/acquisitions", 2))
    assert [job["id"] for page in pages_of_two for job in page["items"]] == whole
    assert {len(page["items"]) for page in pages_of_two[:-1]} == {2}
    assert "after" in problem(client.get("/acquisitions?after=nobody"), 422)["where"]


def test_a_page_of_jobs_ends_where_it_grows_too_large(client, monkeypatch):
    whole = [job["id"] for job in client.get("/acquisitions").json()["items"]]
    monkeypatch.setattr("platform_daemon.core.web.pages.MOST_BYTES", 10)
    assert [job["id"] for page in pages(client, "/acquisitions", 100) for job in page["items"]] == whole
    assert len(client.get("/acquisitions").json()["items"]) == 1


def test_recordings_that_are_not_on_the_page_are_not_opened(client, recording):
    for name in ("a1", "b2", "c3"):
        (client.folder.recordings / f"{name}.h5").write_bytes(b"no hdf5")
    found = list(pages(client, "/recordings", 2))
    assert len(found) > 1
    ids = [e["id"] for page in found for e in (*page["items"], *page["broken"])]
    assert sorted(ids) == sorted(path.stem for path in client.folder.recordings.glob("*.h5"))
    assert all(len(page["items"]) + len(page["broken"]) <= 2 for page in found)


@pytest.mark.parametrize("path", ["/resonators", "/sequences", "/models"])
def test_other_lists_come_in_pages_too(client, path):
    whole = client.get(path).json()
    parts = list(pages(client, path, 1))
    if path == "/models":
        assert parts == [whole]
    else:
        assert [entry for part in parts for entry in part["items"]] == whole["items"]
        assert len(parts) == len(whole["items"])


@pytest.mark.parametrize("query", ["limit=0", "limit=1001", "limit=x", "after="])
def test_a_page_that_makes_no_sense_is_refused(client, query):
    for path in ("/fits", "/recordings", "/resonators"):
        problem(client.get(f"{path}?{query}"), 422)


def test_every_list_of_the_schema_has_the_same_form(client):
    schema = client.get("/openapi.json").json()
    lists = 0
    for path, item in schema["paths"].items():
        operation = item.get("get", {})
        if operation.get("operationId", "").startswith("list_") or path.endswith(("/shots", "/ledger")):
            name = operation["responses"]["200"]["content"]["application/json"]["schema"]["$ref"].rpartition("/")[2]
            model = schema["components"]["schemas"][name]
            assert list(model["properties"])[:2] == ["items", "next"], path
            assert model["properties"]["items"]["type"] == "array", path
            lists += 1
    assert lists >= 17


def test_every_list_of_the_schema_but_that_of_the_devices_comes_in_pages(client):
    for path, item in client.get("/openapi.json").json()["paths"].items():
        operation = item.get("get", {})
        if operation.get("operationId", "").startswith("list_") and path != "/devices":
            assert {"limit", "after"} <= {p["name"] for p in operation["parameters"]}, path
            assert "Link" in operation["responses"]["200"]["headers"], path
