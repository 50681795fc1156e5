"""`platform-daemon devices` and GET /devices: what is there, in what state, and what went wrong."""

from __future__ import annotations

import json
import subprocess
import sys
import time

import pytest
from fastapi.testclient import TestClient

from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.web.server import create_api
from platform_daemon.processes.assembly import start_engine
from tests.kit.emulated_lab import intruder
from tests.kit.linked_api import linked_context


def command(*arguments):
    program = [sys.executable, "-m", "platform_daemon"]
    return subprocess.run([*program, *map(str, arguments)], capture_output=True, text=True, check=False)


def devices(*arguments):
    return command("devices", *arguments)


def test_every_device_is_a_row_with_its_identity(lab, tmp_path):
    target = tmp_path / "devices.json"
    run = devices("--platform", "emulated", "--endpoints", lab.endpoints, "--json", target)
    assert run.returncode == 0, run.stderr
    found = {row["device"]: row for row in json.loads(target.read_text())["devices"]}
    assert set(found) == {"io_card", "tx_rx_switch", "power_amplifier", "lna"}
    assert all(row["error"] is None and row["identity"]["model"] for row in found.values())
    assert found["lna"]["state"]["gain"] == 40.0
    assert "STEMlab" in run.stdout


def test_a_missing_device_is_a_row_too_and_the_exit_code_is_1(lab, tmp_path):
    target = tmp_path / "devices.json"
    missing = 'lna.port="/dev/no-such-port"'
    run = devices("--platform", "emulated", "--endpoints", lab.endpoints, "--set", missing, "--json", target)
    assert run.returncode == 1
    found = {row["device"]: row for row in json.loads(target.read_text())["devices"]}
    assert "no such serial port" in found["lna"]["error"]
    assert found["lna"]["identity"] is None
    assert found["io_card"]["error"] is None


@pytest.mark.long
def test_a_platform_file_that_does_not_fit_the_lab_is_bad_input_in_one_line(lab, tmp_path):
    for wrong, said in (('lna.identity="ACME"', "another device answers"), ("io_card.server_version=12", "not 12")):
        wanted = ("--platform", "emulated", "--endpoints", lab.endpoints, "--set", wrong)
        run = command("measure", "--resonator", "thread", "--out", tmp_path / "t.h5", *wanted)
        assert run.returncode == 2, run.stderr
        assert len(run.stderr.splitlines()) == 1
        assert said in run.stderr
    assert list(tmp_path.glob("*.h5")) == []


def test_an_address_that_is_not_known_is_bad_input():
    run = devices("--platform", "emulated")
    assert run.returncode == 2
    assert "--endpoints" in run.stderr


def rows_once(client, condition):
    """The devices by name, as soon as the idle engine has read them back so; it does every few seconds."""
    deadline = time.monotonic() + 20
    while True:
        rows = {row["device"]: row for row in client.get("/devices").json()["items"]}
        if condition(rows):
            return rows
        assert time.monotonic() < deadline, rows
        time.sleep(0.05)


def test_over_rest_a_device_that_was_lost_says_so_and_keeps_its_last_error(lab_of_its_own, tmp_path):
    lab = lab_of_its_own()
    engine = start_engine(lab.file())
    try:
        with TestClient(
            create_api(linked_context(engine, open_data_folder(tmp_path))), base_url="http://127.0.0.1"
        ) as client:
            rows = rows_once(client, lambda rows: "io_card" in rows)
            assert all(row["error"] is None for row in rows.values())
            other = intruder(lab)
            rows = rows_once(client, lambda rows: rows["io_card"]["error"])
            assert "another client" in rows["io_card"]["error"]
            assert rows["lna"]["error"] is None
            assert client.post("/stop").status_code == 200
            rows = rows_once(client, lambda rows: rows["io_card"]["error"] is None)
            assert "another client" in rows["io_card"]["last_error"]["error"]
            other.close()
    finally:
        engine.close()
