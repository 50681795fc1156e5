"""Own resonators and sequences: added over REST, versioned, and used by name."""

import uuid

import pytest

from platform_daemon.core.hardware.catalogue import open_catalogue, to_toml
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.settings import load_specimen, locate, read_toml
from tests.kit.rest import finished, problem


@pytest.fixture
def specimen():
    """The shipped jewel, as a lab would describe one of its own."""
    return {**load_specimen("jewel")[0].model_dump(exclude_none=True), "name": 'J-03 of "our" lab'}


def test_a_resonator_is_kept_in_versions_and_measured_by_name(client, specimen):
    key = f"j{uuid.uuid4().hex[:8]}"  # a second attempt meets the catalogue of the first
    first = client.post("/resonators", params={"name": key}, json=specimen)
    assert (first.status_code, first.json()) == (201, {"name": key, "version": 1, "label": f"{key}@1"})
    specimen["measured"]["f_nat_hz"] = 199.5
    second = client.post("/resonators", params={"name": key}, json=specimen)
    assert second.headers["location"] == f"/resonators/{key}@2"
    assert client.get(f"/resonators/{key}").json()["measured"]["f_nat_hz"] == 199.5
    assert client.get(f"/resonators/{key}@1").json()["measured"]["f_nat_hz"] == 213.25
    assert {"jewel", "thread", key, f"{key}@1", f"{key}@2"} <= {
        each["id"] for each in client.get("/resonators").json()["items"]
    }
    body = {"resonator": key, "sequence": {"rx_s": 0.6}}
    assert client.post("/acquisitions/dry-run", json=body).json()["resonator"] == specimen["name"]
    expected = client.post("/predict", json={"resonator": key, "windows": ["n50"]}).json()["expected"]
    assert expected["f_nat_hz"] == pytest.approx(199.5)
    job = finished(client, client.post("/acquisitions", json=body).headers["location"])
    assert job["state"] == "done", job["error"]
    text = open_recording(client.folder.recordings / job["result"]["file"]).configuration_toml()
    assert f"# {key}@2, added" in text


def test_a_sequence_is_kept_in_versions_and_used_as_a_preset(client):
    answer = client.post("/sequences", params={"name": "short"}, json={"rx_s": 0.6, "axis": [1, 1, 0]})
    assert answer.json()["label"] == "short@1"
    listed = {each["id"]: each["sequence"] for each in client.get("/sequences").json()["items"]}
    assert listed["short"] == listed["short@1"] == {"axis": [1.0, 1.0, 0.0], "rx_s": 0.6}
    assert listed["thread"]["rx_s"] == 15.0
    assert client.get("/sequences/short").json() == listed["short"]
    body = {"resonator": "jewel", "preset": "short", "sequence": {"field_t": 1e-4}}
    shot = client.post("/acquisitions/dry-run", json=body).json()["shot"]
    assert (shot["t_rx_s"], shot["field_t"]) == (pytest.approx(0.6, abs=1e-4), 1e-4)


@pytest.mark.parametrize(
    ("kind", "name", "body", "words"),
    [
        ("resonators", "thread", {}, "ships"),
        ("resonators", "../x", {}, "name: must be text of the form"),
        ("resonators", "a@1", {}, "name: must be text of the form"),
        ("resonators", "t1", {"variant": "spring"}, "variant: must be 'thread' or 'jewel'"),
        ("resonators", "t1", {"colour": 1}, "colour: is unknown"),
        ("resonators", "t1", {"thread": {"length_m": 0.01}}, "needs the table [jewel]"),
        ("sequences", "jewel", None, "ships"),
        ("sequences", "s1", {"rx": 1}, "did you mean 'rx_s'?"),
        ("sequences", "s1", {"rx_s": None}, "leave the key out"),
        ("sequences", "s1", {"repetitions": 3}, "repetitions"),
    ],
)
def test_what_cannot_be_kept_is_a_problem(client, specimen, kind, name, body, words):
    content = {"rx_s": 1.0} if body is None else body if kind == "sequences" else specimen | body
    assert words in problem(client.post(f"/{kind}", params={"name": name}, json=content), 422)["detail"]


def test_names_that_do_not_exist_are_problems(client):
    problem(client.get("/resonators/none"), 404)
    problem(client.get("/sequences/none"), 404)
    wrong = {"resonator": "jewel", "preset": "none"}
    assert "no sequence" in problem(client.post("/acquisitions/dry-run", json=wrong), 422)["detail"]
    foreign = {"resonator": "jewel", "preset": "thread"}
    assert "another resonator" in problem(client.post("/acquisitions/dry-run", json=foreign), 422)["detail"]


@pytest.mark.parametrize(
    "content", ["name = ", pytest.param("a = " + "[" * 100_000, id="deep"), 'colour = "red"', "\udcff"]
)
def test_a_damaged_file_is_listed_with_its_problem_and_leaves_the_others_in_use(client, content, specimen):
    folder = client.folder
    bad = [folder.resonators / "bad@1.toml", folder.sequences / "bad@1.toml"]
    for path in bad:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content.encode(errors="surrogateescape"))
    try:
        for kind, kept in (("resonators", {"name": "good"}), ("sequences", {"name": "good"})):
            body = specimen if kind == "resonators" else {"rx_s": 0.6}
            assert client.post(f"/{kind}", params=kept, json=body).status_code == 201
            answer = client.get(f"/{kind}")
            assert answer.status_code == 200
            listed = {each["id"]: each for each in answer.json()["items"]}
            broken = {each["id"]: each for each in answer.json()["broken"]}
            assert {"good", "good@1", "jewel", "thread"} <= set(listed)
            assert set(broken) == {"bad", "bad@1"}
            assert set(listed).isdisjoint(broken)
            assert broken["bad@1"]["path"] == "bad@1.toml"
            assert broken["bad"]["error"]["remedy"]
            assert problem(client.get(f"/{kind}/bad"), 422)["detail"] == broken["bad"]["error"]["detail"]
        body = {"resonator": "good", "preset": "good"}
        job = finished(client, client.post("/acquisitions", json=body).headers["location"])
        assert job["state"] == "done", job["error"]
        problem(client.post("/acquisitions", json={"resonator": "bad"}), 422)
    finally:
        for path in bad:
            path.unlink()


def test_a_damaged_model_is_listed_with_its_problem_beside_the_others(client):
    assert client.get("/models").json()["broken"] == []
    path = client.folder.models / "loud@1.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text("{")
    try:
        (told,) = client.get("/models").json()["broken"]
        assert (told["id"], told["path"], told["error"]["status"]) == ("loud@1", "loud@1.json", 422)
        problem(client.get("/models/loud"), 422)
    finally:
        path.unlink()


def test_what_is_deleted_while_it_is_listed_is_left_out(tmp_path, specimen):
    shelf = open_catalogue(tmp_path / "r", tmp_path / "s").resonators
    shelf.add("gone", load_specimen("thread")[0])
    paths = shelf.files()
    paths["gone"].unlink()
    stale = type("Stale", (type(shelf),), {"files": lambda self: paths})(shelf.kind, shelf.model)
    assert "gone" not in stale.all()
    assert "thread" in stale.all()


def test_the_files_are_those_of_the_command_line(tmp_path, specimen):
    catalogue = open_catalogue(tmp_path / "r", tmp_path / "s")
    kept = catalogue.resonators.add("odd", load_specimen("thread")[0].model_copy(update={"name": 'a "b" \\ \x7f ü \n'}))
    assert load_specimen(kept.path)[0].name == 'a "b" \\ \x7f ü \n'
    for name in ("thread", "jewel"):
        tables = read_toml(locate("resonators", name))[0]
        (tmp_path / "x.toml").write_text(to_toml(tables))
        assert read_toml(tmp_path / "x.toml")[0] == tables
