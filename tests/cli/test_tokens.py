"""`platform-daemon token add | list | revoke`, and a server that is reached by TLS."""

import json
import re
import ssl
import subprocess
import time
from datetime import UTC, datetime, timedelta

import httpx2
import pytest

from platform_daemon.core.schemas.access import Role
from platform_daemon.core.state.audit import audit_log_in
from platform_daemon.core.state.tokens import tokens_in
from tests.kit.command_line import COMMAND, assert_one_line_error, here, wait_for
from tests.kit.data import DATA


def test_a_token_is_printed_once_listed_without_itself_and_taken_back(tmp_path):
    added = here("token", "add", "ann", "--role", "operator", "--expires", "90d", "--data", tmp_path)
    assert added.returncode == 0
    token = added.stdout.strip()
    assert tokens_in(tmp_path).holder(token).role is Role.OPERATOR
    listed = here("token", "list", "--data", tmp_path, "--json", tmp_path / "t.json")
    assert re.search(r"^ann +operator +made \S+, until \S+$", listed.stdout, re.MULTILINE)
    assert token not in listed.stdout
    (record,) = json.loads((tmp_path / "t.json").read_text())["tokens"]
    until = datetime.fromisoformat(record["expires"]) - datetime.now(UTC)
    assert timedelta(days=89.9) < until < timedelta(days=90.1)
    assert here("token", "revoke", "ann", "--data", tmp_path).stdout == "ann is revoked\n"
    assert here("token", "list", "--data", tmp_path).stdout == "no tokens\n"
    assert [(e.what, e.address) for e in audit_log_in(tmp_path).entries()] == [
        ("token_add", "command line"),
        ("token_revoke", "command line"),
    ]


def test_a_user_of_the_computer_without_a_name_is_a_number_in_the_audit_log(tmp_path, monkeypatch):
    def nobody():
        raise KeyError("uid not found")

    monkeypatch.setattr("getpass.getuser", nobody)
    assert here("token", "add", "ann", "--role", "viewer", "--data", tmp_path).returncode == 0
    assert audit_log_in(tmp_path).entries()[0].who.startswith("uid ")


def test_a_token_is_printed_though_the_audit_log_refuses_its_line(tmp_path):
    (tmp_path / "audit.jsonl").mkdir()
    added = here("token", "add", "ann", "--role", "viewer", "--data", tmp_path)
    assert added.returncode == 0
    assert tokens_in(tmp_path).holder(added.stdout.strip()).name == "ann"
    assert "warning" in added.stderr
    assert here("token", "revoke", "ann", "--data", tmp_path).stdout == "ann is revoked\n"


def test_a_data_folder_that_cannot_be_is_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    done = here("token", "add", "ann", "--role", "viewer", "--data", tmp_path / "file")
    assert_one_line_error(done, 2, "data folder cannot be used", "--data")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["add", "ann"], ["--role"]),
        (["add", "ann", "--role", "king"], ["king"]),
        (["add", "a b", "--role", "viewer"], ["no token can be called"]),
        (["add", "ann", "--role", "viewer", "--expires", "soon"], ["no moment", "90d"]),
        (["add", "ann", "--role", "viewer", "--expires", "2020-01-01"], ["expired already"]),
        (["add", "ann", "--role", "viewer", "--expires", "9999-12-31T23:00-10:00"], ["no moment", "90d"]),
        (["revoke", "ann"], ["no token is called", "token list"]),
    ],
)
def test_what_cannot_be_is_one_line(arguments, words, tmp_path):
    assert_one_line_error(here("token", *arguments, "--data", tmp_path), 2, *words)


def _seconds_of(client, address):
    began = time.monotonic()
    assert client.get(address).status_code == 200
    return time.monotonic() - began


@pytest.mark.long
def test_a_server_with_tls_and_tokens_is_reached_by_those_who_trust_it_and_stops_by_either_port(tmp_path):
    data = tmp_path / "data"
    token = tokens_in(data).add("ann", Role.VIEWER)
    files = ["--tls-cert", DATA / "tls/localhost.pem", "--tls-key", DATA / "tls/localhost.key"]
    command = [COMMAND, "serve", "--port", "0", "--data", data, *files]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        main, stop = (process.stdout.readline().split()[-1] for _ in "12")
        assert main.startswith("https://127.0.0.1:")
        trusting = ssl.create_default_context(cafile=str(DATA / "tls/localhost.pem"))
        headers = {"Authorization": f"Bearer {token}"}
        with httpx2.Client(verify=trusting, headers=headers) as client:
            # The kernel would hold back small answers for 40 ms each, as soon as a connection is no longer new.
            assert min([_seconds_of(client, f"{main}/platform") for _ in range(30)][15:]) < 0.03
            assert client.post(f"{main}/acquisitions", json={"resonator": "jewel"}).status_code == 403
            for address in (f"{main}/stop", stop):
                assert client.post(address).json()["status"].startswith("outputs are off")
            assert client.get(f"{main}/platform", headers={"Authorization": ""}).status_code == 401
            tokens_in(data).revoke("ann")
            assert client.get(f"{main}/platform").status_code == client.post(stop).status_code == 401
        with pytest.raises(httpx2.TransportError):
            httpx2.get(f"{main}/health")
        wait_for(lambda: len(audit_log_in(data).entries()) == 2, 5)
    finally:
        process.terminate()
        assert process.wait(30) == 0
