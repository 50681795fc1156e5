"""`python -m tests.page.clients ADDRESS COUNT`: clients that ask a daemon for what so many open pages ask.

They end with the standard input, and print how late each event was at one of them, ms, as a list in JSON.
"""

from __future__ import annotations

import asyncio
import json
import sys
from datetime import UTC, datetime

import httpx2


async def page(client, ready, late_ms):
    """One: its event stream, and the state of the platform and of the job each second."""
    async with client.stream("GET", "/events", timeout=None) as events:
        ready.release()
        await asyncio.gather(listen(events, late_ms), poll(client))


async def listen(events, late_ms):
    """Read what comes."""
    async for line in events.aiter_lines():
        if line.startswith("data:"):
            made = datetime.fromisoformat(json.loads(line.removeprefix("data:"))["at"])
            late_ms.append(1000 * (datetime.now(UTC) - made).total_seconds())


async def poll(client):
    """As live.js does."""
    while True:
        running = (await client.get("/platform")).json()["running"]
        if running:
            await client.get(f"/acquisitions/{running}")
        await asyncio.sleep(1)


async def main(address, count):
    """Until the standard input ends; says when all listen."""
    ready = asyncio.Semaphore(0)
    late_ms: list[list[float]] = [[] for _ in range(count)]
    limits = httpx2.Limits(max_connections=3 * count)
    async with httpx2.AsyncClient(base_url=address, limits=limits, timeout=30) as client:
        tasks = [asyncio.create_task(page(client, ready, each)) for each in late_ms]
        for _ in range(count):
            await ready.acquire()
        print("listening", flush=True)
        await asyncio.to_thread(sys.stdin.read)
        for task in tasks:
            task.cancel()
        for ended in await asyncio.gather(*tasks, return_exceptions=True):
            if not isinstance(ended, asyncio.CancelledError):
                raise ended
    print(json.dumps(late_ms[-1]))


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], int(sys.argv[2])))
