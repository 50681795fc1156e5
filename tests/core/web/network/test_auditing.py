"""What changes the platform is written down: who, from where, what, and how it ended."""

import os
import stat

import pytest
from starlette.testclient import TestClient

from platform_daemon.core.schemas.access import AuditEntry, Role
from platform_daemon.core.state import audit
from platform_daemon.core.state.audit import AuditLog
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.web.network.callers import Authenticator
from platform_daemon.core.web.network.policy import Network
from platform_daemon.core.web.server import create_api
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for
from tests.kit.rest import finished


@pytest.fixture
def entries(secured):
    before = len(secured.audit.entries())
    return lambda: secured.audit.entries()[before:]


def test_a_stop_says_who_from_where_and_that_it_was_done(secured, entries):
    assert secured.client.post("/stop", headers=secured.headers[Role.VIEWER]).status_code == 200
    wait_for(entries, 5)  # the answer does not wait for the disk
    (entry,) = entries()
    assert (entry.who, entry.address, entry.what, entry.path) == ("the-viewer", "testclient", "stop", "/stop")
    assert (entry.status, entry.outcome) == (200, "done")
    assert entry.when.endswith("+00:00")
    assert stat.S_IMODE(secured.audit.path.stat().st_mode) == 0o600


def test_changes_are_listed_newest_first_page_by_page(secured, entries):
    for role in (Role.VIEWER, Role.OPERATOR, Role.ADMIN):
        secured.client.post("/stop", headers=secured.headers[role])
        wait_for(lambda role=role: any(entry.who == f"the-{role}" for entry in entries()), 5)
    headers = secured.headers[Role.VIEWER]
    first = secured.client.get("/changes?limit=2", headers=headers).json()
    assert [each["who"] for each in first["items"]] == ["the-admin", "the-operator"]
    second = secured.client.get(first["next"], headers=headers).json()
    assert second["items"][0]["who"] == "the-viewer"
    assert secured.client.get("/changes").status_code == 401


@pytest.mark.parametrize("block", [7, 65536])
def test_newest_entries_are_read_from_the_end_of_the_file(tmp_path, monkeypatch, block):
    monkeypatch.setattr(audit, "_BLOCK", block)
    log = AuditLog(tmp_path / "audit.jsonl")
    assert log.newest(5) == ((), 0)
    keys = {"when": "now", "address": "", "what": "stop", "path": "", "request": "é", "status": 200, "outcome": "done"}
    for k in range(5):
        log.append(AuditEntry(who=str(k), **keys))
    found, place = log.newest(2)
    assert [entry.who for entry in found] == ["4", "3"]
    found, place = log.newest(2, place)
    assert [entry.who for entry in found] == ["2", "1"]
    assert log.newest(2, place) == (log.entries()[:1], 0)
    with log.path.open("ab") as file:
        file.write(b'{"who": "cut o')
    assert [entry.who for entry in log.newest(2)[0]] == ["4"]


def test_a_path_without_end_makes_no_line_without_end(secured, entries):
    secured.client.post("/stop?x=" + 20_000 * "y", headers=secured.headers[Role.VIEWER])
    wait_for(entries, 5)
    assert len(entries()[0].path) == 2000


def test_reset_calibration_and_series_with_what_was_asked(secured, entries):
    headers = secured.headers[Role.OPERATOR]
    client = secured.client
    assert client.post("/devices/power_amplifier/reset", json={}, headers=headers).status_code == 200
    series = client.post("/acquisitions", json={**SHORT_JEWEL, "beyond_side_modes": True}, headers=headers)
    client.headers.update(headers)
    try:
        finished(client, series.headers["location"])
    finally:
        del client.headers["Authorization"]
    activation = {"kind": "receive"}
    assert client.post("/calibrations/adopt", json=activation, headers=headers).status_code == 403
    adopted = client.post("/calibrations/adopt", json=activation, headers=secured.headers[Role.ADMIN])
    found = entries()
    assert [e.what for e in found][:2] == ["reset_amplifier", "start_acquisition"]
    assert '"beyond_side_modes":true' in found[1].request.replace(" ", "")
    assert found[1].status == 202
    assert ("adopt_calibration" in [e.what for e in found]) == (adopted.status_code == 200)


@pytest.mark.long
def test_what_was_refused_at_once_is_not_written_nor_what_only_looks(secured, entries):
    headers = secured.headers[Role.OPERATOR]
    secured.client.post("/acquisitions", json={"resonator": "spring"}, headers=headers)
    secured.client.post("/acquisitions", json={}, headers=headers)
    secured.client.post("/acquisitions", json=SHORT_JEWEL)
    secured.client.post("/predict", json={"resonator": "jewel"}, headers=headers)
    secured.client.get("/platform", headers=headers)
    assert entries() == ()


def test_what_was_begun_and_failed_is_written_with_the_reason(secured, entries, monkeypatch):

    def fail(*, left):
        from drivers.errors import OutputsUnconfirmed

        raise OutputsUnconfirmed("power may be on", where="power_amplifier", remedy="switch it off by hand")

    monkeypatch.setattr(secured.engine, "outputs_off", fail)
    assert secured.client.post("/stop", headers=secured.headers[Role.ADMIN]).status_code == 502
    wait_for(entries, 5)
    assert "power may be on" in entries()[0].outcome
    assert entries()[0].status == 500


def test_a_disk_that_refuses_does_not_keep_anybody_from_stopping(secured, tmp_path):
    nowhere = Network(authenticator=Authenticator(), audit=AuditLog(tmp_path / "missing" / "audit.jsonl"))
    with TestClient(create_api(secured.client.app.state.context, nowhere), base_url="http://127.0.0.1") as client:
        assert client.post("/stop").status_code == 200
        assert client.post("/devices/power_amplifier/reset", json={}).status_code == 200


def test_the_port_for_stop_asks_the_same_and_can_do_nothing_else(secured, entries):
    assert secured.stopping.post("/stop").status_code == 401
    assert secured.stopping.post("/stop", headers=secured.headers[Role.VIEWER]).status_code == 200
    wait_for(entries, 5)
    assert entries()[0].who == "the-viewer"
    assert secured.stopping.get("/health").status_code == 200
    for path in ("/platform", "/acquisitions", "/docs", "/openapi.json"):
        assert secured.stopping.get(path, headers=secured.headers[Role.ADMIN]).status_code == 404
    evil = {"Host": "evil.example"} | secured.headers[Role.ADMIN]
    assert secured.stopping.post("/stop", headers=evil).status_code == 421


def test_a_line_that_a_power_failure_has_cut_is_left_out(tmp_path):
    log = AuditLog(tmp_path / "audit.jsonl")
    entry = AuditEntry(when="x", who="a\nb", address="", what="stop", path="", request="", status=200, outcome="done")
    log.append(entry)
    with log.path.open("a") as file:
        file.write('{"when": "2026')
    assert log.entries() == (entry,)


def test_what_comes_after_a_line_that_a_full_disk_has_cut_stands_on_a_line_of_its_own(tmp_path, monkeypatch):
    log = AuditLog(tmp_path / "audit.jsonl")
    entry = AuditEntry(when="x", who="a", address="", what="stop", path="", request="", status=200, outcome="done")
    write = os.write
    monkeypatch.setattr(os, "write", lambda file, line: write(file, line[:20]))
    with pytest.raises(StorageError, match="No space left"):
        log.append(entry)
    monkeypatch.undo()
    log.append(entry)
    assert log.entries() == (entry,)
