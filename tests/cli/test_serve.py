"""`platform-daemon serve` as a process."""

import signal
import subprocess

import httpx2

from platform_daemon.settings import locate
from tests.kit.command_line import COMMAND, assert_one_line_error, run
from tests.kit.daemon_process import daemon


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


def test_a_folder_of_resonators_is_offered_by_name_and_checked_first(tmp_path):
    lab = tmp_path / "lab"
    lab.mkdir()
    (lab / "t07.toml").write_text(locate("resonators", "thread").read_text())
    with daemon(tmp_path / "data", "--resonators", lab) as address:
        assert set(httpx2.get(f"{address}/resonators").json()) == {
            "jewel",
            "jewel_imperfect",
            "thread",
            "thread_imperfect",
            "t07",
        }
        asked = {"resonator": "t07", "sequence": {"rx_s": 0.6}}
        assert httpx2.post(f"{address}/acquisitions/dry-run", json=asked).json()["variant"] == "thread"
    (lab / "broken.toml").write_text("variant = 1\n")
    refused = run("serve", "--port", "0", "--data", tmp_path / "data", "--resonators", lab)
    assert_one_line_error(refused, 2, "broken.toml", "variant")
    shipped = locate("resonators", "jewel").parent
    hidden = run("serve", "--port", "0", "--data", tmp_path / "data", "--resonators", shipped)
    assert_one_line_error(hidden, 2, "ships")
