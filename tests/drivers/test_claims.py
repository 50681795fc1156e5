"""A claim is held by a process, not by a file: by whatever account, and behind whatever mounts."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from uuid import uuid4

import pytest

from drivers.claims import Claim, Claimed, holder_of
from drivers.errors import DeviceDenied
from drivers.red_pitaya.lock import lock_card, note_path
from tests.kit.command_line import wait_for
from tests.kit.unit_isolation import isolated, needs_namespaces

HOLD = (
    "import sys, time; from drivers.claims import Claim\n"
    "held = Claim(sys.argv[1], b'who'); print('held', flush=True); time.sleep(60)\n"
)
ANOTHER = 12345


@pytest.fixture
def name():
    return uuid4().hex  # of this computer: other tests run at the same time


def holding(name, command=lambda words: words):
    words = [sys.executable, "-c", HOLD, name]
    process = subprocess.Popen(command(words), stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"held\n"
    return process


def states(pid):
    """Of all threads: one letter each, T for halted."""
    texts = (each.read_text() for each in Path(f"/proc/{pid}/task").glob("*/stat"))
    return {text.rpartition(")")[2].split()[0] for text in texts}


def ended(process):
    process.kill()
    process.wait()
    process.stdout.close()


def test_one_process_holds_a_name_until_it_lets_it_go(name):
    assert holder_of(name) is None
    for _ in range(20):  # released at once, whatever the thread that answers is at
        claim = Claim(name, b"record")
        with pytest.raises(Claimed):
            Claim(name)
        holder = holder_of(name)
        assert (holder.pid, holder.account, holder.record) == (os.getpid(), os.getuid(), b"record")
        claim.close()
        claim.close()
    assert holder_of(name) is None


def test_a_process_that_is_killed_holds_nothing(name):
    process = holding(name)
    try:
        assert (holder_of(name).pid, holder_of(name).record) == (process.pid, b"who")
    finally:
        ended(process)
    Claim(name).close()


@pytest.mark.long
def test_a_process_that_is_halted_holds_it_and_is_named(name):
    process = holding(name)
    try:
        os.kill(process.pid, signal.SIGSTOP)
        wait_for(lambda: states(process.pid) == {"T"})  # until then a thread may still answer
        for _ in range(40):  # more than wait in its queue
            if (found := holder_of(name)).pid == 0:
                break
            assert (found.pid, found.record) == (process.pid, None)
        with pytest.raises(Claimed):
            Claim(name)
    finally:
        ended(process)


def test_a_child_that_inherits_it_holds_it_as_long_as_it_lives(name):
    claim = Claim(name)
    child = subprocess.Popen(["sleep", "60"], pass_fds=[claim.fd])
    claim.forget()
    try:
        with pytest.raises(Claimed):
            Claim(name)
    finally:
        child.kill()
        child.wait()


@needs_namespaces
@pytest.mark.parametrize("account", [None, ANOTHER])
def test_a_service_of_another_account_and_with_a_tmp_of_its_own_is_seen(name, account):
    process = holding(name, lambda words: isolated(words, [], account))
    try:
        with pytest.raises(Claimed):
            Claim(name)
        found = holder_of(name)
        assert (found.record, found.account) == (b"who", account or os.getuid())
    finally:
        ended(process)


@needs_namespaces
def test_a_card_is_held_across_mounts_and_what_another_account_has_left_holds_nothing(tmp_path, monkeypatch):
    port = 20000 + os.getpid() % 10000
    program = (
        f"from drivers.red_pitaya.lock import lock_card; lock_card('127.0.0.1', {port}); print('held', flush=True)\n"
        "import time; time.sleep(60)"
    )
    command = isolated([sys.executable, "-c", program], [], ANOTHER)
    process = subprocess.Popen(command, stdout=subprocess.PIPE)
    try:
        assert process.stdout.readline() == b"held\n"
        with pytest.raises(DeviceDenied, match=f"process {process.pid} holds it"):
            lock_card("localhost", port)
    finally:
        ended(process)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    note_path("127.0.0.1", port).mkdir()  # nothing that could be opened
    with lock_card("127.0.0.1", port) as lock:
        lock.note_recording(time.monotonic())
        assert lock.recording_until() == float("-inf")
