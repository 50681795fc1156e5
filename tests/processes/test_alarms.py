"""Alarms and numbers of a real daemon."""

import http.server
import json
import threading

import pytest
from prometheus_client.parser import text_string_to_metric_families

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for
from tests.kit.rest import problem
from tests.kit.served import served


@pytest.fixture
def pager():
    """A server that is called; what it got."""
    got = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_POST(self):
            got.append(json.loads(self.rfile.read(int(self.headers["content-length"]))))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *arguments):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/", got
    server.shutdown()


def numbers(daemon):
    text = daemon.get("/metrics").text
    return {
        (sample.name, *sample.labels.values()): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


@pytest.mark.long
def test_shots_that_are_refused_raise_an_alarm_that_is_called_acknowledged_and_over(tmp_path, pager):
    url, got = pager
    rx_overload = ("--set", "backends.simulated.lna.overload_v=1e-9")
    with served(tmp_path / "data", "--alarm-url", url, *rx_overload) as daemon:
        job = daemon.post("/acquisitions", {**SHORT_JEWEL, "shots": 5}).json()["id"]
        wait_for(lambda: daemon.get(f"/acquisitions/{job}").json()["state"] == "failed")
        wait_for(
            lambda: {each["name"] for each in daemon.get("/alarms").json()["items"]} >= {"shots", "failed:acquisition"}
        )
        wait_for(lambda: len(got) >= 2)
        told = next(each for each in got if each["name"] == "shots")
        assert "3 of the last 3 shots were refused" in told["what"]
        known = daemon.post("/alarms/shots/acknowledge", {"by": "me"})
        assert (known.status_code, known.json()["acknowledged_by"]) == (200, "me")
        problem(daemon.post("/alarms/unknown/acknowledge", {"by": "me"}), 404)
        problem(daemon.post("/alarms/shots/acknowledge", {}), 422)
        found = numbers(daemon)
        assert found["mmr_shots_total", "refused"] == 3
        assert found["mmr_alarms",] == 2
        assert found["mmr_hardware_up",] == 1
        assert found["mmr_jobs_total", "acquisition", "failed"] == 1
    with served(tmp_path / "data") as daemon:
        assert "shots" in {each["name"] for each in daemon.get("/alarms").json()["items"]}
        job = daemon.post("/acquisitions", {**SHORT_JEWEL, "shots": 10}).json()["id"]
        wait_for(lambda: daemon.get(f"/acquisitions/{job}").json()["state"] == "done")
        wait_for(lambda: all(each["cleared"] for each in daemon.get("/alarms").json()["items"]))
        assert numbers(daemon)["mmr_fit_seconds_count",] == 10
