"""The daemon as processes: each may die, the others go on, and nothing is left behind."""

import os
import signal
import time
from pathlib import Path

import pytest

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for
from tests.kit.served import served

SERIES = {**SHORT_JEWEL, "shots": 60}


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def ended(daemon, location):
    wait_for(lambda: daemon.get(location).json()["state"] in ("done", "failed", "cancelled"), 120)
    return daemon.get(location).json()


@pytest.mark.long
def test_a_series_goes_on_while_the_web_process_is_killed_and_started_anew(daemon):
    location = daemon.post("/acquisitions", SERIES).headers["location"]
    wait_for(lambda: daemon.get(location).json()["progress"]["done"] >= 2)
    before = daemon.kill("web")
    began = time.monotonic()
    job = daemon.get(location).json()  # the socket is the parent's: clients wait, and are not refused
    assert time.monotonic() - began < 20
    assert job["state"] in ("running", "done")
    assert daemon.pid("web") not in (None, before)
    assert ended(daemon, location)["result"]["shots"] == SERIES["shots"]


@pytest.mark.long
def test_after_the_hardware_process_is_killed_it_comes_back_and_acknowledged_shots_are_there(daemon):
    location = daemon.post("/acquisitions", SERIES).headers["location"]
    wait_for(lambda: daemon.get(location).json()["progress"]["done"] >= 5)
    daemon.kill("hardware")
    wait_for(lambda: daemon.get("/platform").status_code == 200)
    job = ended(daemon, location)
    assert job["state"] == "failed"
    recording = daemon.get(f"/recordings/{location.rsplit('/', 1)[1]}").json()
    assert len(recording["shots"] if "shots" in recording else recording["frames"]) >= 5
    assert ended(daemon, daemon.post("/acquisitions", SHORT_JEWEL).headers["location"])["state"] == "done"


def test_while_the_hardware_process_hangs_the_web_answers_and_says_so(daemon):
    hangs = daemon.kill("hardware", signal.SIGSTOP)
    try:
        assert daemon.get("/health").status_code == 200
        assert daemon.get("/recordings").status_code == 200
    finally:
        os.kill(hangs, signal.SIGCONT)
    assert daemon.get("/platform").status_code == 200


def test_stop_has_its_own_port_and_ends_the_series(daemon):
    location = daemon.post("/acquisitions", SERIES).headers["location"]
    wait_for(lambda: daemon.get(location).json()["state"] == "running")
    assert daemon.stop_all().status_code == 200
    assert ended(daemon, location)["state"] == "cancelled"


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_when_the_parent_ends_all_do_and_the_series_is_put_together(tmp_path, number):
    with served(tmp_path / "data") as daemon:
        children = [daemon.pid("hardware"), daemon.pid("web")]
        location = daemon.post("/acquisitions", SERIES).headers["location"]
        wait_for(lambda: daemon.get(location).json()["progress"]["done"] >= 3)
        daemon.process.send_signal(number)
        daemon.process.wait(60)
        wait_for(lambda: not any(map(is_alive, children)))
    assert len(list((tmp_path / "data/recordings").glob("*.h5"))) == 1
    assert not (tmp_path / "data/hardware.sock").exists()


@pytest.mark.long
def test_devices_that_do_not_open_are_told_by_the_web_and_tried_again(tmp_path):
    folder = tmp_path / "data"
    with served(folder, "--platform", "lab") as daemon:
        told = daemon.get("/platform")
        assert told.status_code in (502, 504)
        assert told.json()["remedy"]
        assert daemon.get("/ready").json()["warm"]["platform"] is False
        assert daemon.get("/resonators").status_code == 200
        assert daemon.post("/acquisitions", SHORT_JEWEL).status_code in (502, 504)
    log = folder.with_suffix(".log").read_text()
    assert log.count("devices_not_open") == 1
