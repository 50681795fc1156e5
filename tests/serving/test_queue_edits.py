"""What waits is put in order, paused and changed; what was cut off is resumed in its own recording."""

import json
import os
import signal

import numpy as np
import pytest

from platform_daemon.store import open_recording
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for
from tests.kit.rest import problem
from tests.kit.served import served

LONG = {**SHORT_JEWEL, "shots": 300, "window": None}
SERIES = {**SHORT_JEWEL, "shots": 30, "window": "n50"}


def state(daemon, job):
    return daemon.get(f"/acquisitions/{job}").json()["state"]


def asked(daemon, **keys):
    return daemon.post("/acquisitions", {**SHORT_JEWEL, **keys}).json()["id"]


def queued(daemon):
    return daemon.get("/platform").json()["queued"]


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
        made = [daemon.get(f"/acquisitions/{each}").json() for each in (c, a, b)]
        assert [each["state"] for each in made] == ["done"] * 3
        assert made[0]["started"] < made[1]["started"] < made[2]["started"]
        assert made[1]["result"]["shots"] == 2


def test_a_series_rests_between_two_shots_and_others_go_first_if_it_has_not_begun(daemon):
    running = daemon.post("/acquisitions", LONG).json()["id"]
    waiting, other = asked(daemon), asked(daemon)
    daemon.post(f"/acquisitions/{waiting}/pause", {})
    wait_for(lambda: daemon.get(f"/acquisitions/{running}").json()["progress"]["done"] > 3)
    daemon.post(f"/acquisitions/{running}/pause", {})
    wait_for(lambda: daemon.get(f"/acquisitions/{running}").json()["progress"]["phase"] == "paused")
    status = daemon.get("/platform").json()
    assert not status["power_amplifier"]["enabled"]
    at = daemon.get(f"/acquisitions/{running}/shots?limit=1000").json()["shots"]
    assert daemon.post(f"/acquisitions/{running}/resume", {}).status_code == 202
    wait_for(lambda: len(daemon.get(f"/acquisitions/{running}/shots?limit=1000").json()["shots"]) > len(at))
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
            wait_for(lambda n=3 * cut: len(daemon.get(f"/acquisitions/{job}/shots").json()["shots"]) >= n)
            os.kill(daemon.pid("hardware"), signal.SIGKILL)
            wait_for(lambda: path.exists() and daemon.get("/platform").status_code == 200)
            assert state(daemon, job) == "failed"
            assert f"POST /acquisitions/{job}/resume" in daemon.get(f"/acquisitions/{job}").json()["error"]["remedy"]
            found = open_recording(path)
            before = [found.frame_volts(k) for k in range(found.frames)]
            assert daemon.post(f"/acquisitions/{job}/resume", {}).status_code == 202
        wait_for(lambda: state(daemon, job) in ("done", "failed"))
        told = daemon.get(f"/acquisitions/{job}").json()
        shots = daemon.get(f"/acquisitions/{job}/shots").json()["shots"]
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
    assert json.loads((data / f"jobs/{job}.json").read_text())["state"] == "done"
