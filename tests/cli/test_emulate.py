"""`platform-daemon emulate` as a process."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.kit.emulator_client import LAB

COMMAND = [sys.executable, "-m", "platform_daemon", "emulate"]


def started(target: Path, *more: str) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [*COMMAND, "--json", str(target), *more], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    end = time.monotonic() + 60
    while not target.exists() and process.poll() is None:
        assert time.monotonic() < end
        time.sleep(0.02)
    return process


@pytest.fixture(scope="module")
def running(tmp_path_factory) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    target = tmp_path_factory.mktemp("emulate") / "endpoints.json"
    process = started(target)
    yield process, target
    process.kill()


def refused(*arguments: str) -> str:
    done = subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    return done.stderr


def test_everything_listens_when_the_file_appears(running):
    _, target = running
    endpoints = json.loads(target.read_text())
    for card in endpoints["io_cards"]:
        for port in (card["command_port"], card["data_port"]):
            socket.create_connection((card["host"], port), timeout=2).close()
    assert set(endpoints["serial"]) == {"switch", "lna"}
    assert all(Path(path).is_char_device() for path in endpoints["serial"].values())
    amplifier = endpoints["usb"]["amplifier"]
    socket.create_connection((amplifier["host"], amplifier["port"]), timeout=2).close()


def test_a_port_in_use_is_one_line_and_exit_2(running, tmp_path):
    port = json.loads(running[1].read_text())["io_cards"][0]["command_port"]
    config = tmp_path / "busy.toml"
    text = LAB.read_text().replace("../", f"{LAB.parent.parent}/")
    config.write_text(text.replace("command_port = 0", f"command_port = {port}", 1))
    complaint = refused("--config", str(config))
    assert str(port) in complaint
    assert "in use" in complaint


def test_a_bad_file_is_one_line_and_exit_2(tmp_path):
    config = tmp_path / "bad.toml"
    config.write_text(LAB.read_text().replace("AO0", "AO9"))
    complaint = refused("--config", str(config))
    assert "io_cards.pa_gate" in complaint
    assert "AO9" in complaint


def test_a_missing_file_is_one_line_and_exit_2():
    assert "nowhere" in refused("--config", "nowhere.toml")


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_cleanly_and_removes_only_what_it_made(tmp_path, number):
    target, mine = tmp_path / "e.json", tmp_path / "mine.txt"
    mine.write_text("mine")
    process = started(target)
    ports = json.loads(target.read_text())
    process.send_signal(number)
    assert process.wait(timeout=20) == 0
    assert os.listdir(tmp_path) == ["mine.txt"]
    assert not any(os.path.lexists(path) for path in ports["serial"].values())
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", ports["io_cards"][0]["command_port"]), timeout=2)


def test_a_file_that_somebody_else_has_rewritten_stays(tmp_path):
    target = tmp_path / "e.json"
    process = started(target)
    target.write_text("{}")
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=20) == 0
    assert target.read_text() == "{}"
