"""The port for stop is a process of its own: whatever happens to the others, it answers, and says what is true."""

import json
import os
import signal
import ssl
import statistics
import subprocess
import sys
import time

import httpx2
import pytest

from drivers.errors import DeviceError
from platform_daemon.core.schemas.stop import StopReport
from platform_daemon.core.service.errors import HardwareAway
from platform_daemon.core.service.server import LinkServer
from platform_daemon.core.service.stopping import Stopper, stop_mark
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import run, wait_for
from tests.kit.data import DATA
from tests.kit.served import served

TYPICAL_S = 1.0
"""Loose, as tests share the computer; inside the web process it was 18 s when that was halted, 2.5 s when it died."""
OFF = StopReport(status="off")
SILENT = """import sys, time; from pathlib import Path; from platform_daemon.core.service.address import listening
listener = listening(Path(sys.argv[1]) / "hardware.sock"); print(flush=True); time.sleep(60)"""


@pytest.fixture(scope="module")
def daemon(tmp_path_factory):
    with served(tmp_path_factory.mktemp("stopped") / "data") as running:
        stopped(running)
        yield running


def stopped(daemon, timeout=60):
    """How long it took, s, and what was said."""
    began = time.monotonic()
    answer = httpx2.post(daemon.stop, timeout=timeout)
    assert answer.status_code == 200, answer.text
    return time.monotonic() - began, answer.json()


@pytest.mark.long
def test_while_the_web_process_is_halted_stop_answers_as_ever(daemon):
    halted = daemon.kill("web", signal.SIGSTOP)
    try:
        took = [stopped(daemon)[0] for _ in range(7)]
    finally:
        os.kill(halted, signal.SIGCONT)
    assert statistics.median(took) < TYPICAL_S


def test_while_the_web_process_is_dead_and_started_anew_stop_answers_as_ever(daemon):
    daemon.kill("web")
    took = [stopped(daemon)[0] for _ in range(7)]
    assert statistics.median(took) < TYPICAL_S
    assert daemon.get("/health").status_code == 200


def test_the_process_for_stop_is_back_after_its_death_and_no_connection_is_refused(daemon):
    before = daemon.kill("stop")
    for _ in range(5):  # the socket is the parent's
        stopped(daemon)
    assert daemon.pid("stop") not in (None, before)


def test_one_that_hangs_is_ended_and_what_waits_does_not_begin_when_the_next_one_is_there(daemon):
    jobs = [daemon.post("/acquisitions", {**SHORT_JEWEL, "shots": 200}).headers["location"] for _ in range(3)]
    wait_for(lambda: daemon.get(jobs[0]).json()["state"] == "running")
    halted = daemon.kill("hardware", signal.SIGSTOP)
    _, said = stopped(daemon)
    assert said["hung"]
    assert "killed" in said["status"]
    assert daemon.pid("hardware") not in (None, halted)
    assert [daemon.get(each).json()["state"] for each in jobs] == ["failed", "cancelled", "cancelled"]
    assert not stopped(daemon)[1]["hung"]
    assert not stop_mark(daemon.folder).is_set


def test_the_main_port_does_the_same(daemon):
    daemon.kill("hardware")
    answer = httpx2.post(f"{daemon.address}/stop", timeout=60)
    assert (answer.status_code, answer.json()["hung"]) == (200, False)


@pytest.mark.long
def test_its_rules_are_those_of_the_main_port_and_who_stopped_is_on_file(tmp_path):
    data = tmp_path / "data"
    token = run("token", "add", "ann", "--role", "viewer", "--data", data).stdout.strip()
    files = ["--tls-cert", DATA / "tls/localhost.pem", "--tls-key", DATA / "tls/localhost.key"]
    with served(data, *files) as daemon:
        assert daemon.stop.startswith("https://")
        trusted = {"verify": ssl.create_default_context(cafile=str(DATA / "tls/localhost.pem")), "timeout": 60}
        bearer = {"Authorization": f"Bearer {token}"}
        url = daemon.stop.replace("127.0.0.1", "localhost")
        assert httpx2.post(url, **trusted).status_code == 401
        assert httpx2.post(url, headers={**bearer, "Origin": "https://evil.example"}, **trusted).status_code == 403
        assert httpx2.post(url, headers={**bearer, "Host": "evil.example"}, **trusted).status_code == 421
        assert httpx2.post(url, headers=bearer, content=b"stop", **trusted).status_code == 415
        assert httpx2.get(url.replace("/stop", "/platform"), headers=bearer, **trusted).status_code == 404
        assert httpx2.post(url, headers=bearer, **trusted).status_code == 200
        wait_for(lambda: '"stop"' in (data / "audit.jsonl").read_text())
    lines = [json.loads(line) for line in (data / "audit.jsonl").read_text().splitlines()]
    assert [(line["who"], line["status"]) for line in lines if line["what"] == "stop"] == [("ann", 200)]


def test_a_process_that_never_answers_is_killed_and_the_answer_says_that_nobody_has_confirmed(tmp_path):
    with subprocess.Popen([sys.executable, "-c", SILENT, str(tmp_path)], stdout=subprocess.PIPE) as silent:
        silent.stdout.readline()
        with pytest.raises(HardwareAway, match="no hardware process has confirmed"):
            Stopper(tmp_path, silent_s=0.5, away_s=0.2).outputs_off()
        assert silent.wait(10) == -signal.SIGKILL
    assert stop_mark(tmp_path).is_set


class Owner:
    """Of the hardware, with devices that take their time or fail."""

    def __init__(self, takes_s=0.0, error=None):
        self.takes_s, self.error = takes_s, error

    def outputs_off(self):
        time.sleep(self.takes_s)
        if self.error:
            raise self.error
        return OFF


@pytest.fixture
def linked(tmp_path):
    servers = []

    def begin(owner, **how):
        servers.append(LinkServer(lambda name: owner, tmp_path, **how))
        return Stopper(tmp_path, silent_s=0.5)

    yield begin
    for each in servers:
        each.close()


def test_devices_that_take_their_time_are_waited_for_and_their_process_lives(linked):
    assert linked(Owner(takes_s=1.5)).outputs_off() == OFF


def test_what_the_owner_raises_is_raised_here(linked, tmp_path):
    told = []
    with pytest.raises(DeviceError, match="it is dark"):
        linked(Owner(error=DeviceError("it is dark")), stopped=lambda: told.append(1)).outputs_off()
    assert told == [1]
    assert not stop_mark(tmp_path).is_set


@pytest.mark.long
def test_the_mark_of_an_earlier_stop_is_made_good_by_one_that_is_confirmed(linked, tmp_path):
    stop_mark(tmp_path).set()
    linked(Owner()).outputs_off()
    assert not stop_mark(tmp_path).is_set


@pytest.mark.long
def test_a_folder_that_is_moved_away_is_stopped_all_the_same(tmp_path):
    folder = tmp_path / "data"
    folder.mkdir()
    server = LinkServer(lambda name: Owner(), folder)
    stopper = Stopper(folder, away_s=0.5)
    folder.rename(tmp_path / "moved")
    try:
        assert stopper.outputs_off() == OFF
    finally:
        server.close()
