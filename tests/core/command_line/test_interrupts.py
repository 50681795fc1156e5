"""Ctrl-C that strikes where Python lets no exception out."""

import os
import subprocess
import sys

import pytest


def python(program):
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=30, check=False)


LOST = """
import signal, time, weakref
from platform_daemon.core.command_line.interrupts import no_interrupt_lost

class Something:
    pass

try:
    with no_interrupt_lost():
        something = Something()
        seen = weakref.ref(something, lambda _: signal.raise_signal(signal.SIGINT))
        del something
        print("not yet", flush=True)
        {then}
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.parametrize("then", ["time.sleep(60)", "raise RuntimeError('what a library made of it')"])
def test_an_interrupt_lost_in_a_callback_is_heeded_nevertheless(then):
    done = python(LOST.format(then=then))
    assert done.stdout == "not yet\ninterrupted\n"
    assert done.stderr == ""
    assert done.returncode == 0


FAILED = """
import signal, weakref
from platform_daemon.cli import main as cli

class Something:
    pass

def app(standalone_mode):
    something = Something()
    seen = weakref.ref(something, lambda _: signal.raise_signal(signal.SIGINT))
    del something
    raise OSError("what a library made of it")

cli.app = app
cli.main()
"""


def test_what_a_lost_interrupt_made_of_a_command_is_no_error_of_the_command():
    done = python(FAILED)
    assert done.returncode == 130
    assert done.stderr == "interrupted; outputs are off\n"


FORGOTTEN = """
from platform_daemon.core.command_line.interrupts import no_interrupt_lost

class Something:
    def __del__(self):
        raise ValueError("something else")

with no_interrupt_lost():
    Something()
"""


def test_anything_else_is_told_as_before():
    done = python(FORGOTTEN)
    assert done.returncode == 0
    assert "ValueError: something else" in done.stderr


COMPUTING = """
import time
from platform_daemon.core.command_line.interrupts import end_at_once
from platform_daemon.diagnosis.shots.thread_pool import shot_pool

try:
    with shot_pool() as pool:
        pool.submit(time.sleep, 60)
        raise KeyboardInterrupt
except KeyboardInterrupt:
    end_at_once()
"""


def test_an_interrupt_does_not_wait_for_a_thread_that_computes():
    done = python(COMPUTING)
    assert done.returncode == 130


HELD_DOWN = """
import signal, time
from platform_daemon.core.command_line.interrupts import heed_one_interrupt

heed_one_interrupt()
try:
    signal.raise_signal(signal.SIGINT)
except KeyboardInterrupt:
    signal.raise_signal(signal.SIGINT)
    signal.raise_signal(signal.SIGTERM)
    print("outputs off")
"""


def test_a_key_held_down_does_not_disturb_the_way_out():
    done = python(HELD_DOWN)
    assert done.stdout == "outputs off\n"
    assert done.returncode == 0


CLOSED = """
import sys, time
from platform_daemon.core.command_line.interrupts import heed_one_interrupt
heed_one_interrupt()
try:
    print("there", flush=True)
    time.sleep(30)
except KeyboardInterrupt:
    print("outputs are off", flush=True)
    print("outputs are off", file=sys.stderr, flush=True)
    sys.exit(130)
"""


def test_a_terminal_that_was_closed_does_not_disturb_the_way_out():
    ours, theirs = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", f"import fcntl, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0)\n{CLOSED}"],
        stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
    )  # fmt: skip
    os.close(theirs)
    assert b"there" in os.read(ours, 100)
    os.close(ours)
    assert process.wait(60) == 130


STRUCK = """
import builtins, os, signal
importing, count = builtins.__import__, 0

def struck(*arguments):
    global count
    count += 1
    if count == {at}:
        signal.raise_signal(signal.SIGINT)
    return importing(*arguments)

from platform_daemon.__main__ import main
builtins.__import__ = struck
main()
"""


@pytest.mark.parametrize("at", [1, 2, 5, 20, 100, 400])
def test_an_interrupt_during_imports_is_no_traceback(at):
    done = python(STRUCK.format(at=at))
    assert done.returncode == 130
    assert done.stderr.startswith("interrupted")
    assert "Traceback" not in done.stderr
