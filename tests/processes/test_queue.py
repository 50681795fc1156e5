"""What waited when the daemon ended waits again, in its order; what ran does not begin again."""

import json
import os
import signal
import time

import pytest

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for
from tests.kit.served import served
from tests.kit.stored_jobs import job_texts

LONG = {**SHORT_JEWEL, "shots": 400}
SWEEP = {"kind": "sweep", "acquisition": SHORT_JEWEL, "over": [{"key": "field_ut", "values": [200, 300]}]}


def queued(daemon):
    """A series that runs, and a series, a calibration and a procedure that wait; their locations."""
    locations = [daemon.post("/acquisitions", LONG).headers["location"]]
    wait_for(lambda: daemon.get(locations[0]).json()["progress"]["done"] >= 2)
    locations.append(daemon.post("/acquisitions", SHORT_JEWEL).headers["location"])
    locations.append(daemon.post("/calibrations", {"kind": "transmit"}).headers["location"])
    return locations


def ended(daemon, location):
    wait_for(lambda: daemon.get(location).json()["state"] in ("done", "failed", "cancelled"), 120)
    return daemon.get(location).json()


@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGKILL])
@pytest.mark.long
def test_a_queue_survives_a_restart_and_is_worked_through_in_order(tmp_path, end):
    with served(tmp_path / "data") as daemon:
        locations = queued(daemon)
        hardware = daemon.pid("hardware")
        if end == signal.SIGKILL:
            daemon.process.kill()
            os.kill(hardware, signal.SIGKILL)
        else:
            daemon.process.terminate()
        daemon.process.wait(60)
        wait_for(lambda: not os.path.exists(f"/proc/{hardware}"))
    texts = job_texts(tmp_path / "data")
    states = [json.loads(texts[location.rsplit("/", 1)[1]])["state"] for location in locations]
    assert states[1:] == ["queued", "queued"]
    with served(tmp_path / "data") as daemon:
        jobs = [ended(daemon, location) for location in locations]
        assert jobs[0]["state"] in ("failed", "cancelled")
        assert jobs[0]["result"]["shots"] >= 2
        assert [job["state"] for job in jobs[1:]] == ["done", "done"], jobs
        assert jobs[1]["created"] < jobs[2]["created"]
        assert jobs[1]["finished"] <= jobs[2]["started"]
        assert len(daemon.get("/acquisitions").json()["items"]) == 2
        assert {r["id"] for r in daemon.get("/recordings").json()["items"]} == {
            location.rsplit("/", 1)[1] for location in locations[:2]
        }


@pytest.mark.long
def test_a_waiting_procedure_is_taken_up_no_step_of_one_that_ran_what_cannot_be_planned_says_why_or_all_is_forgotten(
    tmp_path,
):
    """Three daemons, one after the other: a start takes four seconds of a processor."""
    with served(tmp_path / "data") as daemon:
        added = {key: value for key, value in daemon.get("/resonators/jewel").json().items() if value is not None}
        assert daemon.post("/resonators?name=mine", added).status_code == 201
        slow = {**SWEEP, "acquisition": LONG}
        running = daemon.post("/procedures", slow).headers["location"]
        wait_for(lambda: daemon.get(running).json()["progress"]["done"] >= 1)
        waiting = daemon.post("/procedures", SWEEP).headers["location"]
        of_mine = daemon.post("/acquisitions", {**SHORT_JEWEL, "resonator": "mine"}).headers["location"]
    for file in (tmp_path / "data/resonators").iterdir():
        file.unlink()
    with served(tmp_path / "data") as daemon:
        job = ended(daemon, of_mine)
        assert job["state"] == "failed"
        assert "mine" in job["error"]["detail"]
        assert ended(daemon, waiting)["state"] == "done"
        assert ended(daemon, running)["state"] == "cancelled"
        time.sleep(0.5)
        assert daemon.get("/platform").json()["queued"] == []
        steps = [step for job in daemon.get("/procedures").json()["items"] for step in job["result"]["steps"]]
        made = {acquisition for step in steps for acquisition in step["acquisitions"]}
        assert {job["id"] for job in daemon.get("/acquisitions").json()["items"]} >= made
        locations = queued(daemon)
    with served(tmp_path / "data", "--forget-queue") as daemon:
        for location in locations[1:]:
            job = ended(daemon, location)
            assert job["state"] == "cancelled"
            assert "--forget-queue" in job["warnings"][0]


def test_more_than_the_disk_can_take_is_refused_before_anything_moves(daemon):
    before = daemon.get("/acquisitions").json()["items"]
    huge = {"resonator": "thread", "shots": 1_000_000}
    for path in ("/acquisitions/dry-run", "/acquisitions"):
        answer = daemon.post(path, huge)
        assert answer.status_code == 507, answer.text
        assert answer.json()["type"] == "/problems/storage-unusable"
        assert "free the disk" in answer.json()["remedy"]
    assert daemon.get("/acquisitions").json()["items"] == before
