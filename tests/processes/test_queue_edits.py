"""What waits is put in order, paused and changed; what was cut off is resumed in its own recording."""

import json
import os
import signal

import numpy as np
import pytest

from platform_daemon.core.recordings.reader import open_recording
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for
from tests.kit.rest import problem
from tests.kit.served import served
from tests.kit.stored_jobs import job_texts

LONG = {**SHORT_JEWEL, "shots": 300, "window": None}
SERIES = {**SHORT_JEWEL, "shots": 30, "window": "n50"}
SWEEP = {"kind": "sweep", "acquisition": SHORT_JEWEL, "over": [{"key": "field_ut", "values": [200, 300]}]}
OTHER = {
    "acquisitions": (SHORT_JEWEL, {**SHORT_JEWEL, "shots": 2}, {**SHORT_JEWEL, "resonator": "x"}),
    "procedures": (
        SWEEP,
        {"kind": "tune", "acquisition": {"resonator": "jewel"}},
        {**SWEEP, "acquisition": {"resonator": "x"}},
    ),
    "calibrations": (
        {"kind": "transmit"},
        {"kind": "receive", "repetitions": 1},
        {"kind": "receive", "frequencies_hz": [1, 2]},
    ),
    "self-tests": ({}, {"operator": "DC"}, {"operator": 5}),
}
"""By path: what is asked for, what is asked for in its place, and what cannot be."""


def state(daemon, job):
    return daemon.get(f"/acquisitions/{job}").json()["state"]


def asked(daemon, **keys):
    return daemon.post("/acquisitions", {**SHORT_JEWEL, **keys}).json()["id"]


def queued(daemon):
    return daemon.get("/platform").json()["queued"]


def waiting(daemon, path, **keys):
    return daemon.post(f"/{path}", {**OTHER[path][0], **keys}).json()["id"]


@pytest.mark.long
def test_what_has_not_begun_can_be_changed_whatever_it_is_and_keeps_id_and_place(daemon):
    running = daemon.post("/acquisitions", LONG).json()["id"]
    ids = {path: waiting(daemon, path) for path in OTHER}
    for path, (_, other, never) in OTHER.items():
        before = daemon.get(f"/{path}/{ids[path]}").json()
        problem(daemon.put(f"/{path}/{ids[path]}", never), 422)
        assert daemon.get(f"/{path}/{ids[path]}").json() == before
        edited = daemon.put(f"/{path}/{ids[path]}", other)
        assert (edited.status_code, edited.json()["state"]) == (200, "queued"), edited.text
        assert edited.json()["request"] != before["request"]
        assert all(edited.json()["request"][key] == told for key, told in other.items() if not isinstance(told, dict))
        kept = json.loads(job_texts(daemon.folder)[ids[path]])
        assert kept["request"] == edited.json()["request"] == daemon.get(f"/{path}/{ids[path]}").json()["request"]
    assert queued(daemon) == list(ids.values())
    problem(daemon.put(f"/procedures/{ids['calibrations']}", SWEEP), 404)
    assert "has not begun" in problem(daemon.put(f"/acquisitions/{running}", SHORT_JEWEL), 409)["detail"]
    for path, identifier in ids.items():
        daemon.delete(f"/{path}/{identifier}")
        problem(daemon.put(f"/{path}/{identifier}", OTHER[path][0]), 409)


@pytest.mark.long
def test_the_highest_priority_begins_first_and_can_be_changed_while_it_waits(daemon):
    daemon.post("/acquisitions", LONG)
    ids = {path: waiting(daemon, path, priority=each) for each, path in enumerate(OTHER, start=-1)}
    a, p, c, s = ids.values()
    assert queued(daemon) == [s, c, p, a]
    told = {path: daemon.get(f"/{path}/{identifier}").json() for path, identifier in ids.items()}
    assert [job["priority"] for job in told.values()] == [-1, 0, 1, 2]
    assert told["calibrations"]["request"]["priority"] == 1
    problem(daemon.post("/acquisitions", {**SHORT_JEWEL, "priority": 101}), 422)
    within = {**SWEEP, "acquisition": {**SHORT_JEWEL, "priority": 5}}
    assert "next to" in problem(daemon.post("/procedures", within), 422)["detail"]
    assert daemon.post("/platform/queue", {"priority": {a: 5}}).json()["queued"] == [a, s, c, p]
    assert daemon.post("/platform/queue", {"order": [p]}).json()["queued"] == [p, a, s, c]
    assert daemon.put(f"/self-tests/{s}", {"priority": 50}).json()["priority"] == 50
    urgent = waiting(daemon, "self-tests", priority=100)
    assert queued(daemon) == [p, urgent, s, a, c]
    assert daemon.put(f"/procedures/{p}", {**SWEEP, "priority": -100}).status_code == 200
    assert queued(daemon) == [urgent, s, a, c, p]
    problem(daemon.post("/platform/queue", {}), 422)
    problem(daemon.post("/platform/queue", {"priority": {"nobody": 5}}), 409)


@pytest.mark.long
def test_priorities_and_changes_of_what_waits_outlive_a_kill(tmp_path):
    data = tmp_path / "data"
    with served(data) as daemon:
        daemon.post("/acquisitions", LONG)
        low, sweep = asked(daemon), waiting(daemon, "procedures")
        test = waiting(daemon, "self-tests", priority=5)
        daemon.put(f"/procedures/{sweep}", {**SWEEP, "over": [{"key": "field_ut", "values": [250]}], "priority": 3})
        assert queued(daemon) == [test, sweep, low]
        os.kill(daemon.pid("hardware"), signal.SIGKILL)
        wait_for(lambda: daemon.get("/ready").status_code == 200)
        wait_for(lambda: state(daemon, low) == "done")
        paths = [f"/self-tests/{test}", f"/procedures/{sweep}", f"/acquisitions/{low}"]
        made = [daemon.get(path).json() for path in paths]
    assert [job["state"] for job in made] == ["done"] * 3
    assert [job["priority"] for job in made] == [5, 3, 0]
    assert made[0]["finished"] <= made[1]["started"] <= made[2]["started"]
    assert len(made[1]["result"]["steps"]) == 1


@pytest.mark.long
def test_what_waits_is_put_in_order_paused_and_changed_and_a_restart_keeps_it(tmp_path):
    data = tmp_path / "data"
    with served(data) as daemon:
        long = daemon.post("/acquisitions", LONG).json()["id"]
        a, b, c = (asked(daemon, operator=name) for name in "abc")
        assert queued(daemon) == [a, b, c]
        assert daemon.post("/platform/queue", {"order": [c, a]}).json()["queued"] == [c, a, b]
        assert "does not wait" in problem(daemon.post("/platform/queue", {"order": [b, long]}), 409)["detail"]
        assert "twice" in problem(daemon.post("/platform/queue", {"order": [b, b]}), 422)["detail"]
        assert queued(daemon) == [c, a, b]
        edited = daemon.put(f"/acquisitions/{a}", {**SHORT_JEWEL, "shots": 2})
        assert (edited.status_code, edited.json()["progress"]["total"]) == (200, 2.0)
        refused = daemon.put(f"/acquisitions/{long}", SHORT_JEWEL)
        assert "has not begun" in problem(refused, 409)["detail"]
        bad = daemon.put(f"/acquisitions/{a}", {**SHORT_JEWEL, "resonator": "x"})
        problem(bad, 422)
        daemon.post(f"/acquisitions/{c}/pause", {})
    with served(data) as daemon:
        wait_for(lambda: state(daemon, b) == "done")
        assert state(daemon, c) == "queued"  # one that was paused stays so
        daemon.post(f"/acquisitions/{c}/resume", {})
        wait_for(lambda: state(daemon, c) == "done")
        made = [daemon.get(f"/acquisitions/{each}").json() for each in (a, b, c)]
        assert made[0]["started"] < made[1]["started"] < made[2]["started"]
        assert made[0]["result"]["shots"] == 2


def test_a_series_rests_between_two_shots_and_others_go_first_if_it_has_not_begun(daemon):
    running = daemon.post("/acquisitions", LONG).json()["id"]
    waiting, other = asked(daemon), asked(daemon)
    daemon.post(f"/acquisitions/{waiting}/pause", {})
    wait_for(lambda: daemon.get(f"/acquisitions/{running}").json()["progress"]["done"] > 3)
    daemon.post(f"/acquisitions/{running}/pause", {})
    wait_for(lambda: daemon.get(f"/acquisitions/{running}").json()["progress"]["phase"] == "paused")
    status = daemon.get("/platform").json()
    assert not status["power_amplifier"]["enabled"]
    at = daemon.get(f"/acquisitions/{running}/shots?limit=1000").json()["items"]
    assert daemon.post(f"/acquisitions/{running}/resume", {}).status_code == 202
    wait_for(lambda: len(daemon.get(f"/acquisitions/{running}/shots?limit=1000").json()["items"]) > len(at))
    daemon.delete(f"/acquisitions/{running}")
    wait_for(lambda: state(daemon, other) == "done")
    assert state(daemon, waiting) == "queued"
    daemon.post(f"/acquisitions/{waiting}/resume", {})
    wait_for(lambda: state(daemon, waiting) == "done")
    assert "nothing is missing" in problem(daemon.post(f"/acquisitions/{waiting}/resume", {}), 409)["detail"]


@pytest.mark.long
def test_a_series_that_was_cut_off_twice_goes_on_in_its_own_recording(tmp_path):
    data, cuts = tmp_path / "data", 2
    with served(data, "--set", 'backends.simulated.clock.mode="realtime"') as daemon:
        job = daemon.post("/acquisitions", {**SERIES, "shots": 3 + 4 * cuts}).json()["id"]
        path = data / f"recordings/{job}.h5"
        before = []
        for cut in range(1, cuts + 1):
            wait_for(lambda n=3 * cut: len(daemon.get(f"/acquisitions/{job}/shots").json()["items"]) >= n)
            os.kill(daemon.pid("hardware"), signal.SIGKILL)
            wait_for(lambda: path.exists() and daemon.get("/platform").status_code == 200)
            assert state(daemon, job) == "failed"
            assert f"POST /acquisitions/{job}/resume" in daemon.get(f"/acquisitions/{job}").json()["error"]["remedy"]
            found = open_recording(path)
            before = [found.frame_volts(k) for k in range(found.frames)]
            assert daemon.post(f"/acquisitions/{job}/resume", {}).status_code == 202
        wait_for(lambda: state(daemon, job) in ("done", "failed"))
        told = daemon.get(f"/acquisitions/{job}").json()
        shots = daemon.get(f"/acquisitions/{job}/shots").json()["items"]
    assert told["error"] is None
    assert (told["result"]["shots"], len(shots)) == (3 + 4 * cuts,) * 2
    whole = open_recording(path)
    assert whole.provenance.incomplete is None
    assert [info.shot for info in whole.frame_info] == list(range(1, 4 + 4 * cuts))
    assert sum(info.joined for info in whole.frame_info) == cuts
    assert whole.frame_info[len(before)].joined
    for k, volts in enumerate(before):
        assert np.array_equal(whole.frame_volts(k), volts)
    good = [each for each in shots if each["verdict"] == "good"]  # a busy computer may have been too late for one
    assert len(good) >= 8
    assert all(each["fit"]["verdict"] == "good" for each in good)
    assert not [path for path in (data / "recordings").glob(".*") if not path.name.startswith(".index.db")]
    assert json.loads(job_texts(data)[job])["state"] == "done"
