"""Tokens on a server that runs: missing, wrong, revoked, expired, of a lower role; files that are damaged."""

from datetime import UTC, datetime, timedelta

import pytest

from platform_daemon.api.network.callers import Gate
from platform_daemon.schemas.access import Role, TokenRecord, TokenRecords
from platform_daemon.schemas.base import to_json
from platform_daemon.store.tokens import TokenFile
from tests.kit.rest import problem


def bearer(token):
    return {"Authorization": f"Bearer {token}"}


@pytest.mark.parametrize(
    "headers",
    [{}, bearer(""), bearer("pd_wrong"), {"Authorization": "Basic YTpi"}, {"Authorization": "Bearer"}, bearer("é")],
)
def test_without_a_valid_token_nothing_is_told(secured, headers):
    headers = {key: value.encode() for key, value in headers.items()}
    answer = secured.client.get("/platform", headers=headers)
    assert problem(answer, 401)["type"] == "/problems/unauthenticated"
    assert answer.headers["www-authenticate"] == 'Bearer realm="platform-daemon"'
    assert secured.client.get("/health").status_code == 200
    assert secured.client.get("/docs").status_code == 200


def test_a_token_that_is_revoked_is_refused_at_once(secured):
    headers = bearer(secured.tokens.add("guest", Role.VIEWER))
    assert secured.client.get("/platform", headers=headers).status_code == 200
    TokenFile(secured.tokens.path).revoke("guest")  # as the command does, in another process
    assert "revoked" in problem(secured.client.get("/platform", headers=headers), 401)["detail"]


def test_a_token_that_has_expired_is_refused_and_says_when(secured):
    tokens = TokenFile(secured.tokens.path)
    headers = bearer(tokens.add("brief", Role.ADMIN, datetime.now(UTC) + timedelta(hours=1)))
    assert secured.client.get("/platform", headers=headers).status_code == 200
    past = (datetime.now(UTC) - timedelta(seconds=1)).isoformat()
    records = tuple(r if r.name != "brief" else r.model_copy(update={"expires": past}) for r in tokens.records())
    secured.tokens.path.write_text(to_json(TokenRecords(tokens=records)))
    assert f"has expired on {past}" in problem(secured.client.get("/platform", headers=headers), 401)["detail"]
    tokens.revoke("brief")


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"tokens": [{"name": "x"}]}'])
def test_a_damaged_file_of_tokens_lets_nobody_in(secured, damage):
    before = secured.tokens.path.read_bytes()
    try:
        secured.tokens.path.write_text(damage)
        assert problem(secured.client.get("/platform"), 401)
        answer = secured.client.get("/platform", headers=secured.headers[Role.ADMIN])
        assert "cannot read its tokens" in problem(answer, 401)["detail"]
        assert secured.client.get("/health").status_code == 200
    finally:
        secured.tokens.path.write_bytes(before)


def test_on_loopback_nobody_needs_a_token_until_there_is_a_file_and_then_for_good(tmp_path):
    tokens = TokenFile(tmp_path / "tokens.json")
    gate = Gate(tokens)
    assert gate.caller({}, "127.0.0.1").role is Role.ADMIN
    token = tokens.add("ann", Role.OPERATOR)
    assert gate.caller({}, "127.0.0.1").role is None
    found = gate.caller({"authorization": f"bearer {token}"}, "127.0.0.1")
    assert (found.name, found.role) == ("ann", Role.OPERATOR)
    tokens.path.unlink()
    assert gate.caller({}, "127.0.0.1").role is None
    assert Gate(TokenFile(tmp_path / "none.json"), demanded=True).caller({}, "10.0.0.1").role is None


def test_requests_are_counted_by_token_else_by_address_and_of_ipv6_by_network(tmp_path):
    tokens = TokenFile(tmp_path / "tokens.json")
    free, gate = Gate(), Gate(tokens, demanded=True)
    token = tokens.add("ann", Role.VIEWER)
    assert free.caller({}, "10.0.0.1").client == "10.0.0.1"
    assert free.caller({}, "2001:db8::1").client == free.caller({}, "2001:db8::ffff").client
    assert gate.caller({"authorization": f"Bearer {token}"}, "10.0.0.1").client == "token ann"
    assert gate.caller({"authorization": "Bearer no"}, "10.0.0.1").client == "10.0.0.1"


def test_a_moment_that_cannot_be_read_is_past(tmp_path):
    tokens = TokenFile(tmp_path / "tokens.json")
    token = tokens.add("ann", Role.VIEWER)
    record: TokenRecord = tokens.records()[0].model_copy(update={"expires": "soon"})
    tokens.path.write_text(to_json(TokenRecords(tokens=(record,))))
    refused = Gate(tokens).caller({"authorization": f"Bearer {token}"}, "::1").refused
    assert "expired" in str(refused)
