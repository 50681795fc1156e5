"""Events and shots of a real daemon, while its series run."""

import json
import os
import signal
import threading
import time

import httpx2
import pytest

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for
from tests.kit.rest import problem
from tests.kit.served import ready, served

REALTIME = ("--set", 'backends.simulated.clock.mode="realtime"')
SHOTS = 30
"""So many that a busy computer has answered what is asked meanwhile before the last one."""
SERIES = {**SHORT_JEWEL, "shots": SHOTS, "window": "n50"}


@pytest.fixture(scope="module")
def daemon(tmp_path_factory):
    with ready(tmp_path_factory.mktemp("served") / "data", *REALTIME) as running:  # fits that come while it measures
        yield running


class Listener(threading.Thread):
    """Takes what comes, as a browser does."""

    def __init__(self, daemon, query="", **headers):
        super().__init__(daemon=True)
        self.events, self.connected = [], threading.Event()
        self._asked = f"{daemon.address}/events{query}", headers
        self.start()
        assert self.connected.wait(10)

    def run(self):
        address, headers = self._asked
        try:
            with httpx2.stream("GET", address, headers=headers, timeout=60) as answer:
                assert answer.headers["content-type"].startswith("text/event-stream")
                self.connected.set()
                event = {}
                for line in answer.iter_lines():
                    key, _, value = line.partition(": ")
                    if line:
                        event[key] = value
                    elif "data" in event:
                        self.events.append((event["event"], int(event["id"]), json.loads(event["data"])["what"]))
                        event = {}
        except httpx2.TransportError:  # the daemon has ended
            self.connected.set()

    def of(self, kind):
        return [what for each, _, what in list(self.events) if each == kind]


@pytest.mark.long
def test_a_series_is_told_as_it_comes_and_can_be_looked_at_meanwhile(daemon):
    listener = Listener(daemon)
    job = daemon.post("/acquisitions", SERIES).json()
    path = f"/acquisitions/{job['id']}"
    wait_for(lambda: listener.of("fit"))
    recording = listener.of("shot")[0]["recording"]
    assert daemon.get(path).json()["state"] == "running"
    shots = daemon.get(f"{path}/shots").json()["items"]
    assert shots[0]["fit"]["parameters"]["f_nat_hz"]["value"] == listener.of("fit")[0]["f_nat_hz"]
    frame = f"/recordings/{recording}/frames/0"
    info = daemon.get(f"/recordings/{recording}").json()
    assert "still being measured" in info["incomplete"]
    assert info["frames"] == len(info["shots"]) >= 1
    while_it_runs = daemon.get(f"{frame}/dmdt.npy").content
    harmonics = daemon.get(f"{frame}/harmonics")
    assert harmonics.status_code == 200, harmonics.text
    assert harmonics.json()["frame"] == 0
    assert "so far, and no frame 99" in problem(daemon.get(f"/recordings/{recording}/frames/99/dmdt"), 404)["detail"]
    # The last one: on a busy computer the first picture of a daemon may take longer than what is left of the series.
    assert daemon.get(f"{frame}/picture").content.startswith(b"\x89PNG")
    seen = []
    while daemon.get(path).json()["state"] == "running":
        seen.append(daemon.get(path).json()["progress"]["fraction"])
        time.sleep(0.02)
    assert seen == sorted(seen)
    wait_for(lambda: listener.of("job")[-1]["state"] == "done")
    assert [each["state"] for each in listener.of("job")] == ["queued", "running", "done"]
    assert [each["shot"] for each in listener.of("shot")] == list(range(1, SHOTS + 1))
    assert [each["shot"] for each in listener.of("fit")] == list(range(1, SHOTS + 1))
    assert daemon.get(f"{frame}/dmdt.npy").content == while_it_runs
    after = daemon.get(f"{path}/shots?after=4&limit=1").json()
    assert ([each["shot"] for each in after["items"]], after["next"] is not None) == ([5], True)
    numbers = [number for _, number, _ in listener.events]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


@pytest.mark.long
def test_a_listener_that_was_away_gets_what_it_missed_and_nothing_twice(daemon):
    job = daemon.post("/acquisitions", {**SERIES, "shots": 2}).json()
    wait_for(lambda: daemon.get(f"/acquisitions/{job['id']}").json()["state"] == "done")
    first = Listener(daemon, "?after=0")
    wait_for(lambda: len(first.events) >= 5)
    missed = Listener(daemon, **{"Last-Event-ID": str(first.events[2][1])})
    wait_for(lambda: len(missed.events) >= len(first.events) - 3)
    assert missed.events[: len(first.events) - 3] == first.events[3:]
    only = Listener(daemon, "?after=0&kind=job")
    wait_for(lambda: only.events)
    assert {kind for kind, _, _ in only.events} == {"job"}


@pytest.mark.parametrize(
    ("query", "headers"), [("", {"Last-Event-ID": "x"}), ("?after=-1", {}), ("?after=x", {}), ("?kind=unknown", {})]
)
@pytest.mark.long
def test_a_number_or_kind_that_there_is_not_is_refused_before_anything_is_sent(daemon, query, headers):
    problem(daemon.get(f"/events{query}", headers=headers), 422)


@pytest.mark.long
def test_whoever_was_away_for_long_gets_all_that_is_kept(daemon):
    first = Listener(daemon, f"?after={2**52}")  # of no journal of ours
    wait_for(lambda: first.events)
    assert first.of("dropped") == [{"kind": "dropped", "count": None}]
    from platform_daemon.core.schemas.events import DeviceEvent
    from platform_daemon.core.state.event_journal import EventJournal

    journal = EventJournal(daemon.folder / "events.db")
    for k in range(3000):
        journal.tell(DeviceEvent(device="nobody", error=str(k)))
    journal.close()
    late = Listener(daemon, "?after=0")
    wait_for(lambda: late.of("device") and late.of("device")[-1]["error"] == "2999")
    assert late.of("dropped") == []
    assert [each["error"] for each in late.of("device") if each["device"] == "nobody"] == [str(k) for k in range(3000)]


@pytest.mark.long
def test_shots_of_an_earlier_run_come_from_the_recording(tmp_path):
    data = tmp_path / "data"
    with served(data) as daemon:
        job = daemon.post("/acquisitions", {**SERIES, "shots": 3}).json()
        wait_for(lambda: daemon.get(f"/acquisitions/{job['id']}").json()["state"] == "done")
        before = daemon.get(f"/acquisitions/{job['id']}/shots").json()
        os.kill(daemon.pid("hardware"), signal.SIGTERM)
        wait_for(lambda: daemon.get("/platform").status_code == 200)
    with served(data) as daemon:
        assert daemon.get(f"/acquisitions/{job['id']}/shots").json() == before
