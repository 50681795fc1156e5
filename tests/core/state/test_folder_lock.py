"""Who works in a data folder, and who only ends there."""

import subprocess
import sys
import time
from contextlib import closing

import pytest

from drivers.errors import InputError
from platform_daemon.core.state.folder_lock import lock_folder

HOLDER = """
import sys, time
from pathlib import Path
from platform_daemon.core.state.folder_lock import lock_folder
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
    with closing(lock_folder(tmp_path)) as lock:
        lock.file.truncate(0)
        with pytest.raises(InputError, match="another daemon"):
            lock_folder(tmp_path)


def test_whoever_removes_the_file_lets_nobody_in(tmp_path):
    with closing(lock_folder(tmp_path)):
        (tmp_path / ".lock").unlink()
        with pytest.raises(InputError, match="another daemon"):
            lock_folder(tmp_path)
    lock_folder(tmp_path).close()


def test_a_folder_that_is_moved_away_keeps_another_folder_from_being_used(tmp_path):
    (tmp_path / "data").mkdir()
    with closing(lock_folder(tmp_path / "data")):
        (tmp_path / "data").rename(tmp_path / "moved")
        (tmp_path / "data").mkdir()
        lock_folder(tmp_path / "data").close()
