"""What a client can make the server hold: bodies, requests a second, requests at once."""

import asyncio

import pytest
from starlette.testclient import TestClient

from platform_daemon.core.schemas.access import Role
from platform_daemon.core.web.network.access import Takes
from platform_daemon.core.web.network.concurrency import ConcurrencyLimits
from platform_daemon.core.web.network.limits import Limits
from platform_daemon.core.web.network.middleware import MAX_CLIENTS, RateLimiter
from platform_daemon.core.web.network.policy import Network
from platform_daemon.core.web.network.refusals import Busy, TooManyRequests
from platform_daemon.core.web.server import create_api
from tests.kit.rest import problem

JSON = {"content-type": "application/json"}


def chunks(size):
    """A body of so many bytes whose length is not told before."""
    for _ in range(size // 50_000):
        yield b" " * 50_000


@pytest.mark.parametrize("path", ["/acquisitions", "/predict", "/stop"])
def test_a_body_over_a_megabyte_is_refused_whether_its_length_is_told_or_not(secured, path):
    headers = secured.headers[Role.ADMIN] | JSON
    told = problem(secured.client.post(path, content=b" " * 1_000_001, headers=headers), 413)
    assert "at most 1000000 are taken" in told["detail"]
    assert problem(secured.client.post(path, content=chunks(2_000_000), headers=headers), 413)["remedy"]


def test_a_body_of_a_megabyte_is_read_and_a_get_may_have_none_that_is_longer(secured):
    headers = secured.headers[Role.ADMIN] | JSON
    body = b'{"resonator": "spring"}'.ljust(1_000_000)
    assert "spring" in problem(secured.client.post("/predict", content=body, headers=headers), 422)["detail"]
    problem(secured.client.request("GET", "/platform", content=b" " * 1_000_001, headers=headers), 413)


def test_a_missing_token_is_told_before_a_body_is_looked_at(secured):
    assert problem(secured.client.post("/acquisitions", content=b" " * 2_000_000, headers=JSON), 401)


def test_who_asks_too_often_is_told_how_long_to_wait_and_stop_is_never_counted(secured):
    context = secured.client.app.state.context
    few = Network(limits=Limits(requests_per_s=2, burst=5))
    with TestClient(create_api(context, few), base_url="http://127.0.0.1") as client:
        assert [client.get("/health").status_code for _ in range(6)] == 5 * [200] + [429]
        answer = client.get("/health")
        assert problem(answer, 429)["remedy"]
        assert 1 <= int(answer.headers["retry-after"]) <= 3
        assert {client.post("/stop").status_code for _ in range(10)} == {200}


def test_a_poller_at_20_hz_is_never_refused_and_one_at_a_thousand_is():
    now = 0.0
    limits = Limits()
    rate = RateLimiter(limits.requests_per_s, limits.burst, lambda: now)
    for _ in range(20 * 600):
        rate.count("poller")
        now += 1 / 20
    refused = 0
    for _ in range(10_000):
        now += 1e-3
        try:
            rate.count("flood")
        except TooManyRequests:
            refused += 1
    assert refused == pytest.approx(10_000 - limits.burst - 10 * limits.requests_per_s, abs=5)
    rate.count("poller")


def test_clients_that_come_and_go_leave_nothing_behind():
    rate = RateLimiter(1, 1, lambda: 0.0)
    for number in range(3 * MAX_CLIENTS):
        rate.count(str(number))
    with pytest.raises(TooManyRequests):
        rate.count(str(3 * MAX_CLIENTS - 1))
    rate.count("0")


def test_of_requests_that_compute_two_run_some_wait_and_others_are_told_to_come_again():
    async def crowd():
        limiters = ConcurrencyLimits(Limits(computing=2, waiting=3, patience_s=0.2))
        free, running, most = asyncio.Event(), 0, 0

        async def one():
            nonlocal running, most
            async with limiters.for_work(Takes.COMPUTING):
                running += 1
                most = max(most, running)
                await free.wait()
                running -= 1

        tasks = [asyncio.create_task(one()) for _ in range(10)]
        await asyncio.sleep(0.05)
        async with limiters.for_work(Takes.READING), limiters.for_work(Takes.NOTHING):  # not held up by them
            refused = sum(isinstance(t.exception(), Busy) for t in tasks if t.done())
        await asyncio.sleep(0.3)
        late = sum(isinstance(t.exception(), Busy) for t in tasks if t.done())
        free.set()
        await asyncio.gather(*tasks, return_exceptions=True)
        return most, refused, late

    assert asyncio.run(crowd()) == (2, 5, 8)


def test_a_key_that_is_there_twice_is_refused_wherever_it_is(secured):
    """The last of two values would decide in silence; what is no JSON is told by whoever reads it."""
    headers = {**secured.headers[Role.OPERATOR], "Content-Type": "application/json"}
    for body in (b'{"resonator": "jewel", "shots": 1, "shots": 5}', b'{"sequence": {"rx_s": 1, "rx_s": 2}}'):
        said = problem(secured.client.post("/acquisitions/dry-run", content=body, headers=headers), 422)
        assert "is there twice" in said["detail"]
        assert said["remedy"]
    for body in (b"{", b"\xff", b"1" * 5000, b"[" * 100_000):
        problem(secured.client.post("/acquisitions/dry-run", content=body, headers=headers), 422)
