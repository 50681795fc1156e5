"""What a service manager hears, over the datagram socket of sd_notify(3)."""

from __future__ import annotations

import os
import socket
import time

import pytest

from platform_daemon.core.guard.notify import Heartbeat, notify, service_manager, watchdog_s


@pytest.fixture
def manager(tmp_path, monkeypatch):
    path = str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
        heard.bind(path)
        heard.settimeout(5)
        monkeypatch.setenv("NOTIFY_SOCKET", path)
        yield heard


def all_of(heard):
    heard.setblocking(False)
    said = []
    while True:
        try:
            said.append(heard.recv(100).decode())
        except BlockingIOError:
            return said


def test_ready_alive_ending(manager, monkeypatch):
    monkeypatch.setenv("WATCHDOG_USEC", "100000")
    monkeypatch.setenv("WATCHDOG_PID", str(os.getpid()))
    with service_manager():
        assert manager.recv(100) == b"READY=1"
        for _ in range(3):
            assert manager.recv(100) == b"WATCHDOG=1"
    assert all_of(manager)[-1] == "STOPPING=1"


@pytest.mark.parametrize("dead", [lambda: False, lambda: 1 / 0])
def test_no_sign_of_life_of_what_does_not_live(manager, monkeypatch, dead):
    monkeypatch.setenv("WATCHDOG_USEC", "20000")
    with service_manager(dead):
        time.sleep(0.2)
    assert all_of(manager) == ["READY=1", "STOPPING=1"]


def test_a_heart_that_stops_lives_no_longer(manager, monkeypatch):
    monkeypatch.setenv("WATCHDOG_USEC", "20000")
    heart = Heartbeat(0.1)
    with service_manager(heart.lives):
        time.sleep(0.3)
        assert "WATCHDOG=1" in all_of(manager)
        time.sleep(0.1)
        assert all_of(manager) == []
        heart()
        time.sleep(0.05)
        assert "WATCHDOG=1" in all_of(manager)


@pytest.mark.parametrize("listens", ["no manager", "a manager that has gone"])
def test_without_a_manager_that_listens_the_daemon_serves_and_no_watchdog_runs(tmp_path, monkeypatch, listens):
    monkeypatch.setenv("WATCHDOG_USEC", "20000")
    monkeypatch.delenv("WATCHDOG_PID", raising=False)
    monkeypatch.setenv("NOTIFY_SOCKET", "" if listens == "no manager" else str(tmp_path / "gone"))
    calls = []
    with service_manager(lambda: bool(calls.append("lives"))):
        time.sleep(0.05)  # two and a half times WATCHDOG_USEC
    assert calls == []
    assert not notify("READY=1")


def test_a_watchdog_of_another_process_is_not_ours(monkeypatch):
    monkeypatch.setenv("WATCHDOG_USEC", "1000000")
    monkeypatch.setenv("WATCHDOG_PID", "1")
    assert watchdog_s() is None
    monkeypatch.setenv("WATCHDOG_PID", str(os.getpid()))
    assert watchdog_s() == 1.0
