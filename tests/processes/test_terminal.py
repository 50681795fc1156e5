"""What is said on a terminal that is closed, halted or full costs lines, and nothing else."""

import contextlib
import os
import socket
import subprocess
import sys
import time

import httpx2
import pytest

from tests.kit.command_line import COMMAND, wait_for
from tests.kit.served import Served

LOGS = """
import logging, pathlib, sys, time, structlog
from platform_daemon.core.state import logs
logs.log_from(logging.INFO)
if len(sys.argv) > 1:
    logs.keep_log(pathlib.Path(sys.argv[1]), "hardware")
began = time.monotonic()
for k in range(3000):
    structlog.get_logger().info("job_started", job=f"acquisition-{k}")
print("logged" if time.monotonic() - began < 5 else "held up", flush=True)
"""


@pytest.fixture
def unread():
    """A pipe that nobody reads, and whose reader lives."""
    reader, writer = os.pipe()
    yield writer
    os.close(reader)
    os.close(writer)


@pytest.mark.parametrize("kept", [True, False])
@pytest.mark.parametrize("where", ["full", "closed"])
def test_whoever_logs_is_not_ended(tmp_path, where, kept):
    with open("/dev/full", "w") as full:
        kind = {"stderr": full} if where == "full" else {"preexec_fn": lambda: os.close(2)}
        command = [sys.executable, "-c", LOGS, *([tmp_path / "logs"] if kept else [])]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, timeout=30, check=True, **kind)
    assert done.stdout == "logged\n"


def test_whoever_logs_is_not_held_up(tmp_path, unread):
    command = [sys.executable, "-c", LOGS, tmp_path / "logs"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=unread, text=True, timeout=30, check=True)
    assert done.stdout == "logged\n"
    assert "acquisition-2999" in (tmp_path / "logs/hardware.jsonl").read_text()


def started(data, out, **streams):
    """A daemon that cannot say where it is, but for a file that takes what it prints."""
    command = [COMMAND, "serve", "--port", "0", "--data", data]
    with out.open("w") as file:
        process = subprocess.Popen(command, stdout=file, **streams)
    try:
        wait_for(lambda: "stop on" in out.read_text() or process.poll() is not None)
        assert process.poll() is None
        printed = out.read_text().splitlines()
        [address] = (line.split()[-1] for line in printed if line.startswith("listening on "))
        [stop] = (line.split()[-1] for line in printed if line.startswith("stop on "))
    except BaseException:  # nobody else knows of it
        process.terminate()
        raise
    return Served(process, address, stop, data)


@pytest.mark.long
def test_a_daemon_whose_terminal_refuses_works_and_starts_anew_what_dies(tmp_path):
    with open("/dev/full", "w") as full:
        daemon = started(tmp_path / "data", tmp_path / "out", stderr=full)
    try:
        location = daemon.post("/acquisitions", {"resonator": "jewel", "shots": 1}).headers["location"]
        wait_for(lambda: daemon.get(location).json()["state"] == "done", 120)
        before = daemon.kill("web")
        wait_for(lambda: daemon.pid("web") not in (None, before))
        time.sleep(1)
        assert daemon.process.poll() is None
    finally:
        daemon.process.terminate()
        daemon.process.wait(60)
        daemon.close()


@pytest.mark.long
def test_a_daemon_without_standard_input_and_error_serves(tmp_path):
    def close():
        os.close(0)
        os.close(2)

    daemon = started(tmp_path / "data", tmp_path / "out", preexec_fn=close)
    try:
        assert daemon.get("/platform").status_code == 200
    finally:
        daemon.process.terminate()
        daemon.process.wait(60)
        daemon.close()


def test_what_is_opened_does_not_get_the_number_of_a_closed_stream():
    program = (
        "import os; from platform_daemon.__main__ import _have_standard_streams as have\n"
        "have()\n"
        "other = os.open('/dev/zero', os.O_RDONLY)\n"
        "print(other > 2, all(map(os.get_inheritable, range(3))))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        preexec_fn=lambda: (os.close(0), os.close(2)),
        check=True,
    )
    assert done.stdout == b"True True\n"


@pytest.mark.long
@pytest.mark.parametrize("where", ["full", "unread"])
def test_a_daemon_that_cannot_say_where_it_listens_serves_all_the_same(tmp_path, unread, where):
    os.set_blocking(unread, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(unread, bytes(4096))
    os.set_blocking(unread, True)
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    command = [COMMAND, "serve", "--port", str(port), "--data", tmp_path / "data"]
    with open("/dev/full", "w") as full:
        process = subprocess.Popen(command, stdout=full if where == "full" else unread, stderr=subprocess.DEVNULL)
    daemon = Served(process, f"http://127.0.0.1:{port}", "", tmp_path / "data")
    try:
        wait_for(lambda: answers(daemon), 60)
        before = daemon.kill("web")
        wait_for(lambda: daemon.pid("web") not in (None, before) and answers(daemon), 30)
        assert process.poll() is None
    finally:
        process.terminate()
        assert process.wait(60) == 0
        daemon.close()


def answers(daemon):
    try:
        return daemon.get("/health").status_code == 200
    except httpx2.TransportError:
        return False
