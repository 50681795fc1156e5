"""`python -m tests.page.clients ADDRESS COUNT`: clients that ask a daemon for what so many open pages ask."""

from __future__ import annotations

import asyncio
import sys

import httpx2


async def page(client, ready):
    """One: its event stream, and the state of the platform and of the job each second."""
    async with client.stream("GET", "/events", timeout=None) as events:
        ready.release()
        await asyncio.gather(listen(events), poll(client))


async def listen(events):
    """Read what comes."""
    async for _ in events.aiter_lines():
        pass


async def poll(client):
    """As live.js does."""
    while True:
        running = (await client.get("/platform")).json()["running"]
        if running:
            await client.get(f"/acquisitions/{running}")
        await asyncio.sleep(1)


async def main(address, count):
    """Until it is ended; says when all listen."""
    ready = asyncio.Semaphore(0)
    limits = httpx2.Limits(max_connections=3 * count)
    async with httpx2.AsyncClient(base_url=address, limits=limits, timeout=30) as client, asyncio.TaskGroup() as tasks:
        for _ in range(count):
            tasks.create_task(page(client, ready))
        for _ in range(count):
            await ready.acquire()
        print("listening", flush=True)


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], int(sys.argv[2])))
