"""Loopback as it is; any other address only with tokens, TLS or a plain no to it; one line says what is missing."""

import pytest

from drivers.errors import PlatformError
from platform_daemon.core.schemas.access import Role
from platform_daemon.core.state.audit import AuditLog
from platform_daemon.core.state.tokens import TokenFile
from platform_daemon.core.web.network.certificates import Certificate
from platform_daemon.core.web.network.listening import certificate_of, is_loopback, rules
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.data import DATA

OURS = Certificate(DATA / "tls/localhost.pem", DATA / "tls/localhost.key")


@pytest.fixture
def asked(tmp_path):
    tokens, audit = TokenFile(tmp_path / "tokens.json"), AuditLog(tmp_path / "audit.jsonl")

    def asked(host, *names, certificate=None, insecure=False, token=False):
        if token:
            tokens.add("ann", Role.ADMIN)
        return rules(host, names, certificate, insecure=insecure, tokens=tokens, audit=audit)

    return asked


@pytest.mark.parametrize("host", ["127.0.0.1", "127.3.4.5", "localhost", "::1"])
def test_loopback_needs_neither_tokens_nor_tls(asked, host):
    assert is_loopback(host)
    network = asked(host)
    assert {host, "localhost", "127.0.0.1", "::1"} == network.names | {host}
    assert network.authenticator.caller({}, host).role is Role.ADMIN


@pytest.mark.parametrize(
    ("host", "keys", "word"),
    [
        ("0.0.0.0", {}, "TLS"),
        ("192.0.2.1", {}, "--insecure-network"),
        ("lab.example", {}, "--tls-cert"),
        ("::", {"insecure": True, "token": True}, "--allowed-host"),
        ("0.0.0.0", {"insecure": True, "token": True}, "--allowed-host"),
        ("192.0.2.1", {"insecure": True}, "token add"),
        ("192.0.2.1", {"certificate": OURS, "token": True}, "192.0.2.1"),
    ],
)
def test_an_address_that_others_reach_says_what_it_lacks(asked, host, keys, word):
    with pytest.raises(PlatformError, match=word) as refused:
        asked(host, **keys)
    assert refused.value.nothing_moved
    assert refused.value.remedy


def test_with_all_of_it_others_may_come_by_the_names_that_were_given_and_tokens_are_demanded(asked):
    network = asked("0.0.0.0", "LocalHost", certificate=OURS, token=True)
    assert network.names == {"127.0.0.1", "localhost", "::1"}
    assert network.authenticator.caller({}, "127.0.0.1").role is None
    assert "lab.example" in asked("192.0.2.1", "lab.example", insecure=True).names


@pytest.mark.parametrize("name", ["", "*@x", "lab.example:8212", "https://lab.example", "[::1]", "a b"])
def test_a_further_name_that_no_request_can_give_is_refused(asked, name):
    with pytest.raises(PlatformError, match="no name of a server") as refused:
        asked("192.0.2.1", name, insecure=True, token=True)
    assert refused.value.where == "--allowed-host"
    with pytest.raises(PlatformError, match="no name of a server") as refused:
        asked(name, "lab.example", insecure=True)
    assert refused.value.where == "--host"


def test_a_further_name_may_be_written_as_people_do(asked):
    assert {"lab.example", "2001:db8::1"} <= asked("127.0.0.1", "Lab.Example.", "2001:DB8::1").names


def test_tokens_that_have_all_been_revoked_are_none(asked, tmp_path):
    asked("127.0.0.1", token=True)
    TokenFile(tmp_path / "tokens.json").revoke("ann")
    with pytest.raises(PlatformError, match="no tokens"):
        asked("192.0.2.1", insecure=True)


def test_one_file_of_tls_alone_is_refused():
    for pair, missing in (((OURS.chain, None), "--tls-key"), ((None, OURS.key), "--tls-cert")):
        with pytest.raises(PlatformError, match=f"^{missing}: |TLS") as refused:
            certificate_of(*pair)
        assert refused.value.where == missing
    assert certificate_of(None, None) is None


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--host", "0.0.0.0"], ["needs TLS", "--insecure-network"]),
        (["--host", "0.0.0.0", "--insecure-network", "--allowed-host", "lab"], ["no tokens", "token add"]),
        (["--tls-cert", "x"], ["--tls-key"]),
        (["--tls-cert", DATA / "tls/other.pem", "--tls-key", DATA / "tls/other.key"], ["127.0.0.1", "mismatch"]),
    ],
)
def test_serve_ends_with_one_line_and_code_2(options, words, tmp_path):
    assert_one_line_error(here("serve", "--port", "0", "--data", tmp_path / "data", *options), 2, *words, "Remedy")
    assert not (tmp_path / "data").exists()
