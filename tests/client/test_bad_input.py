"""Each mistake is one exception that says what, where and what to do."""

import socket
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from drivers.errors import InputError, PlatformError
from platform_daemon.client import (
    AccessDenied,
    Client,
    ClientError,
    ConnectionFailed,
    InvalidRequest,
    JobEnded,
    NotADaemon,
    NotFound,
    VersionMismatch,
)
from platform_daemon.core.schemas.roles import Role
from platform_daemon.core.state.tokens import tokens_in
from tests.kit.served import served


@pytest.fixture
def answering():
    """Makes a server that answers every GET with this."""
    servers = []

    def made(content, content_type="application/json", status=200):
        class Handler(BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(status)
                self.send_header("Content-Type", content_type)
                self.end_headers()
                self.wfile.write(content)

            def log_message(self, *args):
                pass

        servers.append(HTTPServer(("127.0.0.1", 0), Handler))
        threading.Thread(target=servers[-1].serve_forever, daemon=True).start()
        return f"http://127.0.0.1:{servers[-1].server_port}"

    yield made
    for each in servers:
        each.shutdown()
        each.server_close()


def check_said(error):
    """What every error of the client says."""
    assert isinstance(error, PlatformError)
    assert error.where
    assert error.remedy
    assert "\n" not in str(error)


def test_nothing_listens_at_the_address():
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with Client(f"http://127.0.0.1:{port}") as lab, pytest.raises(ConnectionFailed, match="nothing answers") as found:
        lab.measure("jewel")
    check_said(found.value)
    assert str(port) in found.value.where


@pytest.mark.parametrize("url", ["127.0.0.1:8000", "ftp://lab", "http://", "http://lab:port", "lab"])
def test_an_address_that_is_none(url):
    with pytest.raises(InputError, match="no address of a daemon") as found:
        Client(url)
    check_said(found.value)


def test_no_address_at_all(monkeypatch):
    monkeypatch.delenv("PLATFORM_DAEMON_URL", raising=False)
    with pytest.raises(InputError, match="PLATFORM_DAEMON_URL") as found:
        Client()
    check_said(found.value)


def test_another_program_at_the_address(answering):
    url = answering(b"<html>a printer</html>", "text/html")
    with Client(url) as lab, pytest.raises(NotADaemon, match="no platform daemon") as found:
        lab.platform()
    check_said(found.value)


def test_a_daemon_of_another_version_is_said_at_the_first_call(answering):
    url = answering(b'{"status": "ok", "version": "9.9.9"}')
    with Client(url) as lab, pytest.raises(VersionMismatch, match=r"9\.9\.9") as found:
        lab.measure("jewel")
    check_said(found.value)
    assert "platform-daemon==9.9.9" in found.value.remedy


@pytest.mark.long
def test_a_token_that_is_wrong_or_of_too_low_a_role(tmp_path):
    token = tokens_in(tmp_path / "data").add("ann", Role.VIEWER)
    with served(tmp_path / "data") as daemon:
        with Client(daemon.address, token="wrong") as lab, pytest.raises(AccessDenied) as found:
            lab.platform()
        check_said(found.value)
        assert found.value.status == 401
        with Client(daemon.address, token=token) as lab:
            assert lab.platform() is not None
            with pytest.raises(AccessDenied) as found:
                lab.measure("jewel")
        check_said(found.value)
        assert found.value.status == 403


def test_a_job_that_does_not_exist(lab):
    with pytest.raises(NotFound) as found:
        lab.job("acquisition-20200101T000000-abcdef")
    check_said(found.value)
    with pytest.raises(InputError, match="no job is of the kind"):
        lab.job("walk-1")
    with pytest.raises(NotFound):
        lab.recordings["nothing"].info()
    with pytest.raises(NotFound):
        lab.specimens["nothing"].get()


def test_a_series_is_no_diagnosis_to_be_adopted(lab, series):
    for given in (series.id, lab.job(series.id)):
        with pytest.raises(InputError, match="is no diagnosis") as found:
            lab.adopt(given, "draughty", by="DC")
        check_said(found.value)


def test_a_collection_is_listed_and_a_loop_over_itself_does_not_run_for_ever(lab):
    for there in (lab.recordings, lab.schedules, lab.specimens):
        with pytest.raises(TypeError, match="not iterable"):
            iter(there)


def test_a_job_of_a_client_that_is_closed(running, series):
    with Client(running.address) as lab:
        job = lab.job(series.id)
    for call in (job.refresh, job.fits, lab.stop, lambda: next(iter(lab.events()))):
        with pytest.raises(InputError, match="the client is closed") as found:
            call()
        check_said(found.value)


def test_an_argument_that_is_not_there(lab):
    with pytest.raises(InputError, match="fild_ut") as found:
        lab.measure("jewel", fild_ut=490)
    check_said(found.value)
    assert "field_ut" in found.value.remedy


def test_a_key_in_two_units(lab):
    with pytest.raises(InputError, match="are the same"):
        lab.measure("jewel", field_t=4e-4, field_ut=400)


def test_degrees_for_radians(lab):
    with pytest.raises(InputError, match="90 degrees") as found:
        lab.measure("jewel", phase_rad=90)
    check_said(found.value)


def test_tesla_for_microtesla(lab):
    with pytest.raises(InputError, match="490 uT"):
        lab.measure("jewel", field_t=490)


def test_what_only_the_daemon_can_refuse(lab):
    with pytest.raises(InvalidRequest) as found:
        lab.measure("a resonator that there is not")
    check_said(found.value)
    assert found.value.problem.status == 422
    assert found.value.why
    assert isinstance(found.value, ClientError)


def test_a_job_has_no_result_before_its_end(lab):
    job = lab.self_test()
    with pytest.raises(JobEnded, match="no result"):
        job.result  # noqa: B018
    job.cancel()


@pytest.mark.parametrize(
    "works", [{}, {"measure": {"resonator": "jewel"}, "self_test": {}}], ids=["no work", "two works"]
)
def test_a_schedule_of_not_one_work(lab, works):
    with pytest.raises(InputError, match="one kind of work") as found:
        lab.schedules.add("night", every_s=60, **works)
    check_said(found.value)
