"""outputs-off, reset-fault and doctor, as programs on the emulated lab and on the simulated platform."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from drivers.power_guard import PowerGuard
from platform_daemon.core.guard.fault_latch import Cause, Fault, latch_fault, latched_fault
from platform_daemon.core.guard.guard_client import guard_for
from platform_daemon.core.guard.state_dir import state_dir_of
from platform_daemon.core.schemas.unattended import Checkup
from tests.kit.dying_host import DyingHost
from tests.kit.emulated_lab import Lab

FAULT = Fault(platform="lab", when="2026-11-23T02:00:00+00:00", owner=7, cause=Cause.DIED, proved=True)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    made = Lab(tmp_path_factory.mktemp("lab"))
    yield made
    made.emulator.close()


def run(*arguments):
    command = [sys.executable, "-m", "platform_daemon", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def on(lab):
    return "--platform", "emulated", "--endpoints", lab.endpoints


@pytest.mark.long
def test_outputs_left_on_are_switched_off_and_proved(lab, tmp_path):
    host = DyingHost(lab, tmp_path)
    try:
        host.wait_for("tx")
        guards = [int(each) for each in children_of(host.process.pid)]
        os.kill(host.process.pid, signal.SIGSTOP)
        for each in guards:  # nobody is left who could do it
            os.kill(each, signal.SIGKILL)
    finally:
        host.end()
    assert host.outputs_on
    done = run("outputs-off", *on(lab))
    assert done.returncode == 0, done.stderr
    assert "outputs are off" in done.stdout
    assert not host.outputs_on
    refused = run("measure", "--resonator", "jewel", "--shots", 1, "--out", tmp_path / "x.h5", *on(lab))
    assert refused.returncode == 2
    assert "died together" in refused.stderr
    assert "reset-fault --by NAME" in refused.stderr
    assert run("reset-fault", "--by", " ", *on(lab)).returncode == 2
    cleared = run("reset-fault", "--by", "anna", *on(lab))
    assert cleared.returncode == 0, cleared.stderr
    assert "cleared by anna" in cleared.stdout
    assert latched_fault(state_dir_of(lab.file().section)) is None
    assert lab.violations() == ()


def children_of(pid):
    with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
        return file.read().split()


def test_outputs_that_cannot_be_proved_off_fail_and_lock(lab, tmp_path):
    at = json.loads(lab.endpoints.read_text())
    at["serial"]["switch"] = str(tmp_path / "no-switch")
    endpoints = tmp_path / "endpoints.json"
    endpoints.write_text(json.dumps(at))
    done = run("outputs-off", "--platform", "emulated", "--endpoints", endpoints)
    assert done.returncode == 1
    assert "outputs could not be confirmed off" in done.stderr
    refused = run("reset-fault", "--by", "anna", "--platform", "emulated", "--endpoints", endpoints)
    assert refused.returncode == 1


def test_a_command_that_owns_the_devices_is_named(lab):
    guard: PowerGuard = guard_for(lab.file().section)
    try:
        done = run("outputs-off", *on(lab))
        assert done.returncode == 1
        assert f"process {os.getpid()}" in done.stderr
        assert f"kill {os.getpid()}" in done.stderr
    finally:
        guard.close()


def test_doctor_finds_what_is_wrong_and_says_what_to_do(lab, tmp_path):
    latch_fault(state_dir_of(lab.file().section), FAULT)
    report = tmp_path / "doctor.json"
    try:
        done = run("doctor", *on(lab), "--data", tmp_path / "new", "--json", report)
    finally:
        lab.reset_fault()
    assert done.returncode == 1, done.stderr
    found = {each.check: each for each in Checkup.model_validate_json(report.read_text()).findings}
    assert found["fault"].verdict == "fail"
    assert "reset-fault" in found["fault"].remedy
    assert found["device: io_card"].verdict == found["device: power_amplifier"].verdict == "ok"
    assert found["disk: write and fsync"].verdict == "ok"
    assert not (tmp_path / "new").exists()
    assert {"disk: room", "memory", "clock: synchronised", "clock: jumps", "port: port", "service", "lease"} <= set(
        found
    )
    assert all(each.remedy for each in found.values() if each.verdict != "ok")


@pytest.mark.long
@pytest.mark.parametrize("folder", ["/proc/data", "file", "file/data", "loop/data", "nowhere", 300 * "a" + "/data"])
def test_doctor_on_a_folder_that_is_none(tmp_path, folder):
    (tmp_path / "file").write_text("")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "nowhere").symlink_to("gone")
    done = run("doctor", "--platform", "simulated", "--data", tmp_path / folder)
    assert done.returncode == 1, done.stdout
    assert "disk" in done.stdout


@pytest.mark.long
def test_a_daemon_that_runs_is_told_to_stop_and_resets_its_fault(lab, tmp_path):
    data = tmp_path / "data"
    latch_fault(state_dir_of(lab.file().section), FAULT)
    command = [sys.executable, "-m", "platform_daemon", "serve", *map(str, on(lab)), "--port", "0", "--data", str(data)]
    with (tmp_path / "log").open("wb") as log:
        daemon = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, start_new_session=True)
    try:
        assert daemon.stdout is not None
        assert b"listening" in daemon.stdout.readline()
        done = run("outputs-off", *on(lab))
        assert done.returncode == 0, done.stderr
        assert "has stopped everything" in done.stdout
        assert '"address": "command line", "what": "stop"' in (data / "audit.jsonl").read_text()
        done = run("reset-fault", "--by", "anna", "--reason", "looked", *on(lab))
        assert done.returncode == 0, done.stderr
        assert latched_fault(state_dir_of(lab.file().section)) is None
        assert "reset_fault" in (data / "audit.jsonl").read_text()
    finally:
        daemon.terminate()
        daemon.wait(60)
    time.sleep(0.1)
