"""A process that is started again serves as before, whatever became of certificate and tokens meanwhile."""

import shutil
import ssl

import httpx2
import pytest

from drivers.errors import ConfigError
from platform_daemon.core.schemas.roles import Role
from platform_daemon.core.state.tokens import tokens_in
from platform_daemon.processes.options import ServeOptions
from platform_daemon.processes.respawn import respawn_options
from platform_daemon.processes.rules import rules_for
from tests.kit.command_line import wait_for
from tests.kit.data import DATA
from tests.kit.served import served


@pytest.fixture
def files(tmp_path):
    """Certificate and key."""
    return [shutil.copy(DATA / f"tls/localhost.{kind}", tmp_path) for kind in ("pem", "key")]


def bearer(token):
    return {"authorization": f"Bearer {token}"}


def test_neither_a_broken_certificate_nor_tokens_that_are_gone_keep_it_from_serving_or_open_it(tmp_path, files):
    tokens = tokens_in(tmp_path / "data")
    token = tokens.add("ann", Role.ADMIN)
    options = ServeOptions(platform="simulated", data=tmp_path / "data", tls_cert=files[0], tls_key=files[1])
    respawned, _ = respawn_options(options)
    shutil.copy(DATA / "tls/other.key", files[1])
    tokens.path.unlink()
    with pytest.raises(ConfigError, match="does not belong"):
        rules_for(options)
    network, certificate = rules_for(respawned)
    ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate.chain, certificate.key)
    assert network.authenticator.caller({}, "127.0.0.1").role is None
    assert network.authenticator.caller(bearer(token), "127.0.0.1").role is Role.VIEWER


def test_without_certificate_and_tokens_none_are_demanded(tmp_path):
    respawned, handed = respawn_options(ServeOptions(platform="simulated", data=tmp_path))
    assert handed == ()
    network, certificate = rules_for(respawned)
    assert certificate is None
    assert network.authenticator.caller({}, "127.0.0.1").role is Role.ADMIN


def test_a_certificate_may_have_as_long_a_name_as_a_file_can(tmp_path, files):
    path = tmp_path / (251 * "c" + ".pem")
    shutil.copy(files[0], path)
    respawned, _ = respawn_options(ServeOptions(platform="simulated", data=tmp_path, tls_cert=path, tls_key=files[1]))
    assert respawned.tls_cert.read_bytes() == path.read_bytes()


@pytest.mark.long
def test_web_and_stop_are_back_though_the_certificate_is_being_renewed(tmp_path, files):
    token = tokens_in(tmp_path / "data").add("ann", Role.VIEWER)
    trusting = ssl.create_default_context(cafile=str(DATA / "tls/localhost.pem"))
    with served(tmp_path / "data", "--tls-cert", files[0], "--tls-key", files[1]) as daemon:
        (tmp_path / "localhost.key").write_text("")
        before = daemon.kill("web"), daemon.kill("stop")
        wait_for(lambda: None not in (now := (daemon.pid("web"), daemon.pid("stop"))) and not {*now} & {*before})
        with httpx2.Client(verify=trusting, headers=bearer(token), timeout=20) as client:
            assert client.post(daemon.stop).status_code == 200
            assert client.get(f"{daemon.address}/platform").status_code == 200
