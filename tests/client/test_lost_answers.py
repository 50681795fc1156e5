"""Connections that are cut: nothing happens twice, and nothing is missed in silence."""

import threading
import time

import pytest

from platform_daemon.client import ChecksumMismatch, Client, ConnectionFailed, EventsDropped
from platform_daemon.client.downloads import Download
from tests.kit.acquisitions import SHORT
from tests.kit.cutting_proxy import cutting_proxy


@pytest.fixture
def proxy(running):
    with cutting_proxy(running.address) as made:
        yield made


@pytest.fixture
def distant(proxy):
    """A client behind the proxy, connected."""
    with Client(proxy.address) as client:
        client.health()
        yield client


def count(lab):
    return len(list(lab.jobs_of("acquisition")))


def test_a_job_whose_answer_is_lost_is_started_once(lab, proxy, distant):
    before = count(lab)
    proxy.cut_now()
    proxy.cut = [20, 20, 20]
    job = distant.measure("jewel", **SHORT)
    assert proxy.cut == []
    assert count(lab) == before + 1
    job.wait(timeout_s=120)


def test_the_same_key_returns_the_first_job(lab):
    first, again = (lab.measure("jewel", idempotency_key="the first of today", **SHORT) for _ in range(2))
    assert first.id == again.id
    first.wait(timeout_s=120)


def test_a_post_that_may_do_something_twice_is_not_repeated(proxy, distant):
    proxy.cut_now()
    proxy.cut = [20]
    with pytest.raises(ConnectionFailed, match="may have been carried out"):
        distant.schedules.add("cut off", self_test={}, every_s=86_400)
    assert len([each for each in distant.schedules.list() if each.request.name == "cut off"]) == 1
    distant.schedules["cut off"].remove()


def test_a_get_is_repeated(proxy, distant):
    proxy.cut_now()
    proxy.cut = [0, 20, 100]
    assert distant.platform() is not None


def test_a_download_that_is_cut_off_is_continued(proxy, distant, series, running, tmp_path):
    proxy.cut_now()
    proxy.cut = [100_000, 50_000, 0, 200]
    path = distant.recordings[series.recording().id].download(tmp_path / "mine.h5")
    assert path.read_bytes() == (running.folder / "recordings" / f"{series.recording().id}.h5").read_bytes()


def test_a_download_that_is_damaged_is_not_kept(series, tmp_path, monkeypatch):
    monkeypatch.setattr(Download, "add", lambda self, chunk, add=Download.add: add(self, chunk[:-1] + b"?"))
    with pytest.raises(ChecksumMismatch, match="SHA-256"):
        series.recording().download(tmp_path / "mine.h5")
    assert list(tmp_path.iterdir()) == []


def test_a_stream_of_events_that_is_cut_is_resumed_without_a_gap(lab, proxy, distant):
    job = lab.measure("jewel", shots=3, **SHORT)
    heard = []
    for event in distant.events(job):
        heard.append(event.id)
        if len(heard) in (1, 3):
            proxy.cut_now()
    assert heard == [event.id for event in lab.events(job)]


def test_a_stream_of_all_events_that_is_cut_before_its_first_one_misses_none(lab, proxy, distant):
    heard = []

    def listen():
        for event in distant.events():
            heard.append(event)
            if event.what.kind == "job" and event.what.state.final:
                return

    before = proxy.connections
    proxy.cut_now()
    thread = threading.Thread(target=listen)
    thread.start()
    while proxy.connections == before:
        time.sleep(0.01)
    time.sleep(0.5)  # the head of the answer has arrived
    assert heard == []
    proxy.cut = [0] * 20  # for 2 s
    proxy.cut_now()
    job = lab.measure("jewel", **SHORT).wait(timeout_s=120)
    thread.join(timeout=60)
    assert not thread.is_alive()
    ids = [event.id for event in lab.events(job)]
    assert [event.id for event in heard if event.id in ids] == ids


def test_events_that_were_dropped_are_an_error(lab, series, monkeypatch):
    first = next(iter(lab.events(series))).id
    with pytest.raises(EventsDropped) as found:
        list(lab.events(after=first - 1_000_000_000))
    assert found.value.count is None
    assert found.value.remedy


def test_wait_outlives_a_web_process_that_is_killed(lab, running):
    job = lab.measure("jewel", shots=3, **SHORT)
    killer = threading.Timer(0.3, lambda: running.kill("web"))
    killer.start()
    job.wait(timeout_s=240)
    killer.join()
    assert len(job.fits()) == 3
