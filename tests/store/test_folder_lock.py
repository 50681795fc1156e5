"""Who works in a data folder, and who only ends there."""

import subprocess
import sys
import time

import pytest

from drivers.errors import InputError
from platform_daemon.store.folder_lock import lock_folder

HOLDER = """
import sys, time
from pathlib import Path
from platform_daemon.store.folder_lock import lock_folder
held = lock_folder(Path(sys.argv[1]))
print("held", flush=True)
time.sleep(float(sys.argv[2]))
"""
PARENT = """
import subprocess, sys
subprocess.run([sys.executable, "-c", *sys.argv[1:]])
"""


@pytest.fixture
def parent(tmp_path):
    """Of a process that holds the folder for three seconds."""
    words = [sys.executable, "-c", PARENT, HOLDER, str(tmp_path), "3"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_a_daemon_that_lives_is_not_waited_for(tmp_path, parent):
    began = time.monotonic()
    with pytest.raises(InputError, match="another daemon works in this folder"):
        lock_folder(tmp_path)
    assert time.monotonic() - began < 1.0
    assert parent.poll() is None


def test_one_that_has_lost_its_parent_is(tmp_path, parent):
    parent.kill()
    parent.wait()
    lock_folder(tmp_path).close()


def test_a_lock_that_says_nothing_is_one_of_somebody_who_lives(tmp_path):
    with lock_folder(tmp_path) as file:
        file.truncate(0)
        with pytest.raises(InputError, match="another daemon"):
            lock_folder(tmp_path)
