"""The stop port is another origin than the page that stops by it."""

import pytest
from starlette.testclient import TestClient

from platform_daemon.core.schemas.stop import StopReport
from platform_daemon.core.web.network.origins import page_origins
from platform_daemon.core.web.network.policy import Network
from platform_daemon.core.web.stop_server import create_stop_api
from tests.kit.rest import problem

PAGE = "http://127.0.0.1:8212"


@pytest.fixture
def stop_port():
    app = create_stop_api(lambda: StopReport(status="off"), Network(port=8212, stop_port=8213))
    with TestClient(app, raise_server_exceptions=False, base_url="http://127.0.0.1:8213") as client:
        yield client


def test_the_page_of_the_main_port_stops_and_reads_the_answer(stop_port):
    answer = stop_port.post("/stop", headers={"Origin": PAGE, "Sec-Fetch-Site": "same-site"})
    assert (answer.status_code, answer.json()["status"]) == (200, "off")
    assert answer.headers["access-control-allow-origin"] == PAGE


def test_the_page_may_send_its_token(stop_port):
    asked = {"Access-Control-Request-Method": "POST", "Access-Control-Request-Headers": "authorization"}
    answer = stop_port.options("/stop", headers={"Origin": PAGE, **asked})
    assert answer.status_code == 200
    assert "authorization" in answer.headers["access-control-allow-headers"].lower()


@pytest.mark.parametrize("origin", ["http://evil.example:8212", "http://127.0.0.1:9000", "http://127.0.0.1", "null"])
def test_no_other_page_stops(stop_port, origin):
    answer = stop_port.post("/stop", headers={"Origin": origin, "Sec-Fetch-Site": "cross-site"})
    problem(answer, 403)
    assert "access-control-allow-origin" not in answer.headers


def test_a_page_of_the_stop_port_does_not_reach_the_main_port(client):
    problem(client.post("/platform/queue", json={}, headers={"Origin": "http://127.0.0.1:8213"}), 403)


def test_the_usual_port_of_a_scheme_is_left_out_of_an_origin():
    assert page_origins({"lab"}, 443) == {"https://lab", "http://lab:443"}
    assert page_origins({"::1"}, 8212) == {"http://[::1]:8212", "https://[::1]:8212"}
    assert page_origins({"lab"}, 0) == set()
