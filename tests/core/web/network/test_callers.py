"""Tokens on a server that runs: missing, wrong, revoked, expired, of a lower role; files that are damaged."""

from datetime import UTC, datetime, timedelta

import pytest

from platform_daemon.core.schemas.access import Role, TokenRecord, TokenRecords
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.state.tokens import TokenFile
from platform_daemon.core.web.network.callers import Authenticator
from tests.kit.rest import problem


def bearer(token):
    return {"Authorization": f"Bearer {token}"}


def test_tokens_cannot_be_demanded_without_a_file_of_them():
    with pytest.raises(ValueError, match="no file"):
        Authenticator(None, demanded=True)


def test_a_file_that_was_there_at_the_start_is_demanded_though_it_is_gone_before_anybody_asks(tmp_path):
    tokens = TokenFile(tmp_path / "tokens.json")
    tokens.add("ann", Role.ADMIN)
    authenticator = Authenticator(tokens)
    tokens.path.unlink()
    assert authenticator.caller({}, "127.0.0.1").role is None


@pytest.mark.parametrize("text", ["", "\udcff", "[" * 100_000, None], ids=["empty", "no text", "deep", "gone"])
def test_while_the_file_is_damaged_who_held_a_token_may_look_and_stop_and_nobody_else_anything(tmp_path, text):
    tokens = TokenFile(tmp_path / "tokens.json")
    ann, bob = (tokens.add(name, Role.ADMIN) for name in ("ann", "bob"))
    authenticator = Authenticator(tokens)
    tokens.revoke("bob")
    assert authenticator.caller({"authorization": f"Bearer {ann}"}, "::1").role is Role.ADMIN
    if text is None:
        tokens.path.unlink()
    else:
        tokens.path.write_text(text, errors="surrogateescape")
    known = authenticator.caller({"authorization": f"Bearer {ann}"}, "::1")
    assert (known.name, known.role) == ("ann", Role.VIEWER)
    for stranger in (bob, "pd_wrong"):
        refused = authenticator.caller({"authorization": f"Bearer {stranger}"}, "::1")
        assert refused.role is None
        assert "cannot read its tokens" in str(refused.refused)


@pytest.mark.parametrize(
    ("one", "other", "together"),
    [
        ("10.0.0.1", "10.0.0.2", False),
        ("::ffff:10.0.0.1", "::ffff:10.0.0.2", False),
        ("::ffff:10.0.0.1", "10.0.0.1", True),
        ("2001:db8::1", "2001:db8::ffff:1", True),
        ("2001:db8::1", "2001:db8:0:1::1", False),
    ],
)
def test_addresses_that_one_computer_may_have_are_one_client(one, other, together):
    authenticator = Authenticator()
    assert (authenticator.caller({}, one).client == authenticator.caller({}, other).client) is together


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
def test_with_a_damaged_file_of_tokens_one_can_only_look_and_stop(secured, damage):
    before, headers = secured.tokens.path.read_bytes(), secured.headers[Role.ADMIN]
    assert secured.client.get("/platform", headers=headers).status_code == 200
    try:
        secured.tokens.path.write_text(damage)
        assert problem(secured.client.get("/platform"), 401)
        assert secured.client.get("/platform", headers=headers).status_code == 200
        assert secured.client.post("/stop", headers=headers).status_code == 200
        answer = secured.client.post("/devices/power_amplifier/reset", headers=headers, json={})
        assert "cannot read its tokens" in problem(answer, 401)["detail"]
        assert secured.client.get("/health").status_code == 200
    finally:
        secured.tokens.path.write_bytes(before)


def test_on_loopback_nobody_needs_a_token_until_there_is_a_file_and_then_for_good(tmp_path):
    tokens = TokenFile(tmp_path / "tokens.json")
    authenticator = Authenticator(tokens)
    assert authenticator.caller({}, "127.0.0.1").role is Role.ADMIN
    token = tokens.add("ann", Role.OPERATOR)
    assert authenticator.caller({}, "127.0.0.1").role is None
    found = authenticator.caller({"authorization": f"bearer {token}"}, "127.0.0.1")
    assert (found.name, found.role) == ("ann", Role.OPERATOR)
    tokens.path.unlink()
    assert authenticator.caller({}, "127.0.0.1").role is None
    assert Authenticator(TokenFile(tmp_path / "none.json"), demanded=True).caller({}, "10.0.0.1").role is None


def test_requests_are_counted_by_token_else_by_address_and_of_ipv6_by_network(tmp_path):
    tokens = TokenFile(tmp_path / "tokens.json")
    free, authenticator = Authenticator(), Authenticator(tokens, demanded=True)
    token = tokens.add("ann", Role.VIEWER)
    assert free.caller({}, "10.0.0.1").client == "10.0.0.1"
    assert free.caller({}, "2001:db8::1").client == free.caller({}, "2001:db8::ffff").client
    assert authenticator.caller({"authorization": f"Bearer {token}"}, "10.0.0.1").client == "token ann"
    assert authenticator.caller({"authorization": "Bearer no"}, "10.0.0.1").client == "10.0.0.1"


def test_a_moment_that_cannot_be_read_is_past(tmp_path):
    tokens = TokenFile(tmp_path / "tokens.json")
    token = tokens.add("ann", Role.VIEWER)
    record: TokenRecord = tokens.records()[0].model_copy(update={"expires": "soon"})
    tokens.path.write_text(to_json(TokenRecords(tokens=(record,))))
    refused = Authenticator(tokens).caller({"authorization": f"Bearer {token}"}, "::1").refused
    assert "expired" in str(refused)
