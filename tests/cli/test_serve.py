"""`platform-daemon serve` as a process."""

import signal
import subprocess

import httpx2

from tests.kit.command_line import COMMAND, assert_one_line_error, run


def test_the_server_answers_and_leaves_cleanly_on_sigterm(tmp_path):
    command = [COMMAND, "serve", "--port", "0", "--data", tmp_path / "data"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    address = process.stdout.readline().split()[-1]
    assert httpx2.get(f"{address}/health").json()["status"] == "ok"
    second = run("serve", "--port", "0", "--data", tmp_path / "data")
    assert_one_line_error(second, 2, "another daemon")
    taken = run("serve", "--port", address.rsplit(":")[-1], "--data", tmp_path / "other")
    assert_one_line_error(taken, 2, "cannot listen")
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=30) == 0
