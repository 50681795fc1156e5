"""A process that exists and sends no heartbeats is killed and restarted."""

import contextlib
import errno
import os
import signal
import subprocess
import sys
import threading

import pytest

from platform_daemon.processes import child, heartbeat
from platform_daemon.processes import daemon as parent
from platform_daemon.processes.daemon import Daemon
from platform_daemon.processes.heartbeat import HeartbeatMonitor, start_heartbeat
from platform_daemon.processes.options import ServeOptions
from tests.kit.command_line import wait_for

LIVES = """import time; from platform_daemon.processes.child import CHECKED, READY, ParentLink
parent = ParentLink(); parent.report(CHECKED); parent.wait_to_go(); parent.report(READY); time.sleep(60)"""


@pytest.fixture
def pipe():
    ends = os.pipe()
    yield ends
    for end in ends:
        os.close(end)


@pytest.fixture
def clock(monkeypatch):
    """Seconds that pass when a test says so."""
    now = [0.0]
    monkeypatch.setattr(heartbeat.time, "monotonic", lambda: now[0])

    def pass_by(seconds):
        now[0] += seconds

    return pass_by


def silent_for(watched, clock, seconds):
    """Asked every second meanwhile; whether it was said to have stopped."""
    found = []
    for _ in range(seconds):
        clock(1.0)
        found.append(watched.timed_out())
    return any(found)


def test_silence_counts_from_the_last_beat_and_is_told_once(pipe, clock):
    watched = HeartbeatMonitor(pipe[0], start_timeout_s=120.0)
    assert not silent_for(watched, clock, 100)
    os.write(pipe[1], b"ready\n..")
    assert not silent_for(watched, clock, 15)
    os.write(pipe[1], b".")
    assert not silent_for(watched, clock, 15)
    assert silent_for(watched, clock, 2)
    assert not silent_for(watched, clock, 10)


def test_a_start_may_take_longer_but_not_for_ever(pipe, clock):
    watched = HeartbeatMonitor(pipe[0], start_timeout_s=30.0)
    assert not silent_for(watched, clock, 29)
    assert silent_for(watched, clock, 3)


def test_after_a_start_that_is_over_the_first_beat_may_be_no_later_than_others(pipe, clock):
    watched = HeartbeatMonitor(pipe[0], start_timeout_s=120.0)
    watched.started()
    assert not silent_for(watched, clock, 15)
    assert silent_for(watched, clock, 2)


def test_time_in_which_nobody_ran_is_not_held_against_it(pipe, clock):
    watched = HeartbeatMonitor(pipe[0], start_timeout_s=30.0)
    clock(3600.0)
    assert not watched.timed_out()


def heartbeats():
    return [thread for thread in threading.enumerate() if thread.name == "heartbeat"]


def test_a_parent_that_is_halted_halts_nobody(monkeypatch):
    monkeypatch.setattr(heartbeat, "PERIOD_S", 0.01)
    reads, writes = os.pipe()
    os.set_blocking(writes, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(writes, bytes(4096))
    start_heartbeat(writes)
    wait_for(lambda: os.read(reads, 65536).endswith(heartbeat.HEARTBEAT))
    os.close(reads)
    wait_for(lambda: not heartbeats())
    os.close(writes)


@pytest.fixture
def started(monkeypatch):
    """Processes that a parent has started: they do nothing but live."""
    start, found = subprocess.Popen, []

    def begun(command, **how):
        found.append(start([sys.executable, "-c", LIVES], **how))
        return found[-1]

    monkeypatch.setattr(child.subprocess, "Popen", begun)
    monkeypatch.setattr(parent, "keep_log", lambda folder, name: None)
    return found


@contextlib.contextmanager
def running(folder):
    """A parent that runs."""
    daemon, ended = Daemon(ServeOptions(platform="simulated", data=folder), ()), threading.Event()

    def runs():
        with contextlib.suppress(KeyboardInterrupt):
            daemon.run(heard)

    def heard():
        if ended.is_set():
            raise KeyboardInterrupt

    thread = threading.Thread(target=runs)
    daemon.start()
    try:
        thread.start()
        yield
    finally:
        ended.set()
        thread.join()
        daemon.end()


def test_a_halted_process_is_killed_and_restarted(tmp_path, monkeypatch, started):
    monkeypatch.setattr(heartbeat, "TIMEOUT_S", 1.5)
    with running(tmp_path):
        halted = started[0]
        halted.send_signal(signal.SIGSTOP)
        wait_for(lambda: len(started) > 3, 10)
        assert halted.returncode == -signal.SIGKILL
        assert started[1].poll() is None


@pytest.mark.long
@pytest.mark.parametrize("call", ["subprocess.Popen", "os.pidfd_open"])
def test_a_process_that_cannot_be_restarted_is_tried_again_and_the_others_go_on(tmp_path, monkeypatch, started, call):
    module, name = call.split(".")
    works, refused = getattr(getattr(child, module), name), []

    def refuse(*args, **how):
        made = works(*args, **how)
        if len(refused) < 2:
            refused.append(made)
            raise OSError(errno.EMFILE, "Too many open files")
        return made

    with running(tmp_path):
        monkeypatch.setattr(getattr(child, module), name, refuse)
        started[0].kill()
        wait_for(lambda: len(started) == 6, 10)
        assert len(refused) == 2
        assert started[1].poll() is None
        if call == "os.pidfd_open":
            assert [each.returncode for each in started[3:5]] == [-signal.SIGKILL] * 2
            for each in refused:
                os.close(each)
        else:
            for each in refused:  # of a process that there would not be
                each.kill()
                each.wait()


def test_a_process_that_reports_nothing_in_its_time_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(child, "_START_S", 0.0)
    silent = child.Child("web", ServeOptions(platform="simulated", data=tmp_path))
    try:
        with pytest.raises(child.StartFailed, match="the web process has reported nothing for 0 s"):
            silent.wait_for(child.CHECKED)
    finally:
        silent.end(0)
