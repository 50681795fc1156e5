"""What a browser and the web process take while a long series runs: the part `soak` of the bench of the page."""

from __future__ import annotations

import statistics
import time

import psutil

from tests.kit.browser import visit
from tests.kit.command_line import wait_for
from tests.kit.served import ready

SERIES = {"resonator": "jewel", "sequence": {"rx_s": 0.3}, "window": None}
WARM_SHOTS = 500  # until then libraries are loaded, and lists fill up to what they keep
LOOK_S = 20.0


def soak(browser, data, shots, limit_s):
    """A page on the wall, with Now, Last shot and Series in turn, until `shots` are there or the time is over."""
    with ready(data) as daemon:
        seen = visit(browser, daemon.address, "?wall")
        began_s = time.monotonic()
        job = daemon.post("/acquisitions", {**SERIES, "shots": shots}).json()["id"]
        looks = list(_looks(seen, daemon, job, limit_s))
        took_s = time.monotonic() - began_s
        daemon.delete(f"/acquisitions/{job}")
        wait_for(lambda: daemon.get(f"/acquisitions/{job}").json()["state"] in ("done", "cancelled"), timeout=600)
        assert seen.errors == []
        seen.context.close()
    if not looks:
        yield "soak on the wall", f"fewer than {WARM_SHOTS} shots in {took_s / 60:.0f} min, nothing measured", "flat"
        return
    quarter = max(1, len(looks) // 4)
    name = f"{looks[-1][0]} shots in {took_s / 60:.0f} min on the wall"
    for k, what in ((1, "heap of the page"), (2, "memory of the web process")):
        first, last = (statistics.median(look[k] for look in part) for part in (looks[:quarter], looks[-quarter:]))
        yield f"{what}, {name}", f"{last:.1f} MB, {last - first:+.1f} MB from the first to the last quarter", "flat"


def _looks(seen, daemon, job, limit_s):
    """Shots so far, heap of the page and memory of the web process, MB, now and then."""
    tools = seen.context.new_cdp_session(seen.page)
    web = psutil.Process(daemon.pid("web"))
    end_s = time.monotonic() + limit_s
    state = "running"
    while state in ("queued", "running") and time.monotonic() < end_s:
        seen.page.wait_for_timeout(LOOK_S * 1000)
        view = daemon.get(f"/acquisitions/{job}").json()
        state, done = view["state"], int(view["progress"]["done"])
        if done >= WARM_SHOTS:
            yield done, _used_mb(tools), web.memory_info().rss / 1e6


def _used_mb(tools):
    """Heap of the page, without what is not used any more."""
    tools.send("HeapProfiler.collectGarbage")
    return tools.send("Runtime.getHeapUsage")["usedSize"] / 1e6
