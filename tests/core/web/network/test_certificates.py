"""Certificates are looked at before anything listens: whose, until when, with which key."""

import pytest

from drivers.errors import ConfigError
from platform_daemon.core.web.network.certificates import Certificate, check_certificate
from tests.kit.data import DATA

TLS = DATA / "tls"


def files(chain, key):
    return Certificate(TLS / chain, TLS / key)


@pytest.mark.parametrize("names", [["localhost"], ["127.0.0.1"], ["localhost", "127.0.0.1"]])
def test_a_certificate_of_this_server_is_taken(names):
    check_certificate(files("localhost.pem", "localhost.key"), names)


@pytest.mark.parametrize(
    ("chain", "key", "words"),
    [
        ("other.pem", "other.key", ["no client would take", "localhost", "--allowed-host"]),
        ("expired.pem", "localhost.key", ["no client would take", "expired"]),
        ("localhost.pem", "other.key", ["the key does not belong to the certificate"]),
        ("missing.pem", "localhost.key", ["--tls-cert cannot be read", "No such file"]),
        ("localhost.pem", "missing.key", ["--tls-key cannot be read", "No such file"]),
        ("localhost.key", "localhost.pem", ["no certificate and key in PEM"]),
        ("README.md", "README.md", ["no certificate and key in PEM"]),
        ("localhost.pem", "locked.key", ["the key has a password"]),
        (".", "localhost.key", ["--tls-cert cannot be read"]),
    ],
)
def test_one_that_no_client_would_take_is_refused_with_the_reason(chain, key, words):
    with pytest.raises(ConfigError) as refused:
        check_certificate(files(chain, key), ["localhost"])
    for word in words:
        assert word in str(refused.value)
    assert refused.value.remedy


def test_the_second_name_counts_as_much_as_the_first():
    with pytest.raises(ConfigError, match=r"lab\.example"):
        check_certificate(files("localhost.pem", "localhost.key"), ["localhost", "lab.example"])
