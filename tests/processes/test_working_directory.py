"""A daemon is one installation, also where the working directory is the checkout of another version."""

import subprocess
import sys
from pathlib import Path


def test_the_processes_of_a_daemon_are_not_taken_from_the_working_directory(tmp_path):
    other = tmp_path / "platform_daemon"
    other.mkdir()
    (other / "__init__.py").write_text("raise SystemExit('of another checkout')\n")
    command = [Path(sys.executable).with_name("platform-daemon"), "serve", "--port", "0", "--data", "data"]
    log = tmp_path / "daemon.log"
    with (
        log.open("w") as errors,
        subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=errors, text=True) as daemon,
    ):
        try:
            assert daemon.stdout is not None
            assert "http" in daemon.stdout.readline(), log.read_text()
        finally:
            daemon.terminate()
    assert "of another checkout" not in log.read_text()
