"""A place in the journal for each listener."""

import asyncio
import json
from types import SimpleNamespace

import pytest
from fastapi.testclient import TestClient

from platform_daemon.core.schemas.events import DeviceEvent
from platform_daemon.core.state.event_journal import EventJournal
from platform_daemon.core.web import event_tail
from platform_daemon.core.web.event_tail import MOST_BEHIND, EventTail
from platform_daemon.core.web.server import create_api
from tests.kit.rest import problem


@pytest.fixture
def path(tmp_path):
    tell(tmp_path / "events.db", range(3000))
    return tmp_path / "events.db"


def tell(path, numbers):
    journal = EventJournal(path)
    for k in numbers:
        journal.tell(DeviceEvent(device="nobody", error=str(k)))
    journal.close()


def error(event):
    return int(json.loads(event.text)["what"]["error"])


def test_who_reads_slowly_what_was_before_loses_nothing_and_who_falls_behind_later_is_told(path):
    async def listened():
        tail = EventTail(path)
        events = tail.follow(0)
        before = [error(await anext(events)) for _ in range(2000)]
        await asyncio.to_thread(tell, path, range(3000, 3500))  # meanwhile
        before += [error(await anext(events)) for _ in range(1500)]
        await asyncio.to_thread(tell, path, range(3500, 6500))
        dropped, first = await anext(events), await anext(events)
        tail.close()
        await events.aclose()
        return before, dropped, first

    before, dropped, first = asyncio.run(listened())
    assert before == list(range(3500))
    count = json.loads(dropped.text)["what"]["count"]
    assert (dropped.kind, error(first)) == ("dropped", 3500 + count)
    assert count == 3000 - MOST_BEHIND


def test_only_so_many_listen_and_who_leaves_makes_room(path, monkeypatch):
    monkeypatch.setattr(event_tail, "MOST_LISTENERS", 2)

    async def listened():
        tail = EventTail(path)
        first, second = tail.follow(0), tail.follow(0)
        assert not tail.full
        await anext(first)
        await anext(second)
        assert tail.full
        assert [event async for event in tail.follow(0)] == []
        await first.aclose()
        assert not tail.full
        tail.close()
        await second.aclose()

    asyncio.run(listened())


def test_nobody_hears_of_anything_before_what_was_known_without_it_is_forgotten(path):
    async def listened():
        heard = []
        tail = EventTail(path, lambda: heard.append(None))
        events = tail.follow(None)
        first = asyncio.ensure_future(anext(events))
        await asyncio.sleep(0.2)
        assert heard == []
        await asyncio.to_thread(tell, path, [7])
        assert error(await first) == 7
        tail.close()
        await events.aclose()
        return heard

    assert asyncio.run(listened()) == [None]


def test_whoever_comes_then_is_told_to_come_again():
    context = SimpleNamespace(events=SimpleNamespace(full=True), hardware=SimpleNamespace(outputs_off=None))
    answer = TestClient(create_api(context), base_url="http://127.0.0.1").get("/events")
    assert "many listen" in problem(answer, 503)["detail"]
    assert answer.headers["retry-after"]
