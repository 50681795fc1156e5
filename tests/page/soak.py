"""What browsers and the web process take while a long series runs: the parts `soak` and `soak-short` of the bench.

One browser is watched for the heap of its page, and the tools that watch it keep the answers of its requests in its
renderer; so a second one, to which tools are attached for the moment of a look only, tells what the page itself takes
of the memory of a renderer, before and after what is not used any more is collected, and what it keeps of the document.

The short one writes the events of eight hours at a shot a second into the journal within minutes; the shots that they
name are those of one short series, so that what grows with the recording itself is seen by the long one only.
"""

from __future__ import annotations

import json
import os
import shutil
import statistics
import subprocess
import tempfile
import time
from contextlib import contextmanager
from urllib.parse import urlsplit

import psutil

from platform_daemon.core.recordings.data_folder import data_paths
from platform_daemon.core.schemas.events import FitEvent, ShotEvent
from platform_daemon.core.state.event_journal import EventJournal
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.browser import visit
from tests.kit.command_line import wait_for
from tests.kit.rest import finished
from tests.kit.served import ready

SERIES = {"resonator": "jewel", "sequence": {"rx_s": 0.3}, "window": "n50"}
PARTS = 8  # of the soak, of which each is a row
WARM_SHOTS = 500  # until then libraries are loaded, and lists fill up to what they keep
LOOK_S = 20.0
NIGHT_SHOTS = 8 * 3600
NIGHT_S = 240.0  # of which the events of the night take
STEP_S = 0.1
WARM_LOOKS = 1  # views are loaded, and the list of events is full
MEMORIES = ("heap", "watched renderer", "renderer", "renderer after collection", "web process", "hardware process")
TOLD = {
    "heap of the page": 0,
    "memory of the renderer that nobody watches": 2,
    "that renderer after what is not used is collected": 3,
    "memory of the web process": 4,
}


def soak(browser, data, shots, limit_s):
    """Pages on the wall, with Now, Last shot and Series in turn, until `shots` are there or the time is over."""
    with ready(data) as daemon, unwatched(daemon) as alone:
        # on a busy computer a request may be answered too late, which the page says
        seen = visit(browser, daemon.address, "?wall", expected_errors=("Failed to load",))
        began_s = time.monotonic()
        job = daemon.post("/acquisitions", {**SERIES, "shots": shots}).json()["id"]
        looks = [look for look in _looks(seen, daemon, alone, job, limit_s) if look[0] >= WARM_SHOTS]
        took_s = time.monotonic() - began_s
        wait_for(lambda: daemon.delete(f"/acquisitions/{job}").status_code < 500, timeout=600)
        wait_for(lambda: daemon.get(f"/acquisitions/{job}").json().get("state") in ("done", "cancelled"), timeout=600)
        assert seen.errors == []
        seen.context.close()
    if not looks:
        yield "soak on the wall", f"fewer than {WARM_SHOTS} shots in {took_s / 60:.0f} min, nothing measured", "flat"
        return
    yield from _rows(looks, f"{looks[-1][0]} shots in {took_s / 60:.0f} min on the wall")
    parts = [looks[k * len(looks) // PARTS : (k + 1) * len(looks) // PARTS] for k in range(PARTS)]
    for part in filter(None, parts):
        told, *used = (statistics.median_low(each) for each in zip(*part, strict=True))
        yield f"memory after {told} shots", _in_mb(used), "flat"


def _in_mb(used):
    return ", ".join(f"{name} {each:.1f} MB" for name, each in zip(MEMORIES, used, strict=True))


def short_soak(browser, data):
    """Pages on the wall that receive the events of a night within minutes."""
    with ready(data) as daemon, unwatched(daemon) as alone:
        made = finished(daemon, daemon.post("/acquisitions", {**SHORT_JEWEL, "shots": 2}).headers["location"])["id"]
        seen = visit(browser, daemon.address, "?wall")
        journal = EventJournal(data_paths(data).events)
        began_s = time.monotonic()
        looks = list(_night(seen, daemon, alone, journal, made))
        took_s = time.monotonic() - began_s
        journal.close()
        assert seen.errors == []
        seen.context.close()
    yield from _rows(looks[WARM_LOOKS:], f"events of {looks[-1][0]} shots in {took_s / 60:.1f} min on the wall")


class Unwatched:
    """A browser to which tools are attached only while `collect` runs, by the pipe of its debugger."""

    def __init__(self, process, asked, answered):
        self.process = psutil.Process(process.pid)
        self._asked, self._answered = asked, answered
        self._number = 0

    def collect(self):
        """Collect what the page does not use any more; returns the document's nodes before and after, and listeners."""
        (page,) = (each for each in self._call("Target.getTargets")["targetInfos"] if each["type"] == "page")
        session = self._call("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        before = self._call("Memory.getDOMCounters", session)["nodes"]
        self._call("HeapProfiler.collectGarbage", session)
        after = self._call("Memory.getDOMCounters", session)
        self._call("Target.detachFromTarget", sessionId=session)
        return page["url"].rpartition("/")[2], before, after["nodes"], after["jsEventListeners"]

    def _call(self, method, session=None, **arguments):
        self._number += 1
        message = {"id": self._number, "method": method, "params": arguments}
        self._asked.write(json.dumps(message | ({"sessionId": session} if session else {})).encode() + b"\0")
        while (answer := self._answer()).get("id") != self._number:
            pass  # of an event
        return answer["result"]

    def _answer(self):
        return json.loads(b"".join(iter(lambda: self._answered.read(1), b"\0")))


@contextmanager
def unwatched(daemon):
    """A browser of its own on the wall, to which no tool stays attached."""
    address = f"{daemon.address}/page/?wall"
    (its_in, asked), (answered, its_out) = os.pipe(), os.pipe()
    shell = f'exec "$@" 3</dev/fd/{its_in} 4>/dev/fd/{its_out}'  # where Chromium wants them
    options = ("--headless", "--no-sandbox", "--no-first-run", "--remote-debugging-pipe")
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile,
        os.fdopen(asked, "wb", 0) as questions,
        os.fdopen(answered, "rb") as answers,
    ):
        process = subprocess.Popen(
            ["sh", "-c", shell, "sh", shutil.which("chromium"), *options, f"--user-data-dir={profile}", address],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, pass_fds=(its_in, its_out),
        )  # fmt: skip
        for each in (its_in, its_out):
            os.close(each)
        alone, port = Unwatched(process, questions, answers), urlsplit(address).port
        try:
            wait_for(lambda: port in _ports(alone.process), timeout=120)  # its stream of events stays open
            yield alone
            assert port in _ports(alone.process), "the browser that nobody watches has lost the page"
        finally:
            process.terminate()
            process.wait(60)


def _ports(process):
    """The ports of others to which a process and its children are connected."""
    family = [process, *process.children(recursive=True)]
    connections = [each for one in family for each in one.net_connections(kind="tcp")]
    return {each.raddr.port for each in connections if each.status == psutil.CONN_ESTABLISHED}


def _night(seen, daemon, alone, journal, made):
    """What `_memory` says of the shots told so far, whenever Now is shown again."""
    memory_now = _memory(seen, daemon, alone)
    now = seen.page.locator("#nav a[aria-current=page][href='#/now']")
    told, was_now, began_s = 0, True, time.monotonic()
    while told < NIGHT_SHOTS:
        due = min(NIGHT_SHOTS, round(NIGHT_SHOTS * (time.monotonic() - began_s) / NIGHT_S))
        for shot in range(told + 1, due + 1):
            for event in _events_of(made, shot):
                journal.tell(event)
        told = due
        seen.page.wait_for_timeout(1000 * STEP_S)
        is_now = now.count() == 1
        if is_now and not was_now:
            yield memory_now(told)
        was_now = is_now
    seen.page.locator(".now", has_text=f"shot {told}").wait_for()  # the wall comes back to Now by itself
    yield memory_now(told)


def _events_of(made, shot):
    about = {"job": made, "shot": shot, "verdict": "good", "reason": None}
    yield ShotEvent(**about, of=NIGHT_SHOTS, recording=made, frame=shot % 2, blank=False)
    yield FitEvent(
        **about, f_nat_hz=213.0, f_nat_std_hz=1e-4, phi_max_rad=0.5, nrmse=0.01, chi2_per_dof=1.0, whiteness=0.5,
        warnings=(), seconds=0.05,
    )  # fmt: skip


def _rows(looks, name):
    quarter = max(1, len(looks) // 4)
    for what, k in TOLD.items():
        first, last = (statistics.median(look[1 + k] for look in part) for part in (looks[:quarter], looks[-quarter:]))
        yield f"{what}, {name}", f"{last:.1f} MB, {last - first:+.1f} MB from the first to the last quarter", "flat"


def _looks(seen, daemon, alone, job, limit_s):
    """What `_memory` says, now and then."""
    memory_now = _memory(seen, daemon, alone)
    end_s = time.monotonic() + limit_s
    state = "running"
    while state in ("queued", "running") and time.monotonic() < end_s:
        seen.page.wait_for_timeout(LOOK_S * 1000)
        answer = daemon.get(f"/acquisitions/{job}")
        if answer.status_code != 200:  # too late, on a busy computer
            continue
        view = answer.json()
        state = view["state"]
        yield memory_now(int(view["progress"]["done"]))


def _memory(seen, daemon, alone):
    """A function that says, for so many shots: these, and in MB what `MEMORIES` names.

    The heap is that of the watched page without what is not used any more, the memory of renderers what they have for
    themselves, and that of the daemon's processes what is resident.
    """
    tools = seen.context.new_cdp_session(seen.page)
    serving = [psutil.Process(daemon.pid(name)) for name in ("web", "hardware")]

    def now(shots):
        tools.send("HeapProfiler.collectGarbage")
        heap = tools.send("Runtime.getHeapUsage")["usedSize"]
        of_alone = alone.process.children(recursive=True)
        of_watched = [each for each in psutil.Process().children(recursive=True) if each not in of_alone]
        drawing = [_drawing(each) for each in (of_watched, of_alone)]
        view, before, after, listeners = alone.collect()
        drawing.append(_drawing(of_alone))
        used = tuple(each / 1e6 for each in (heap, *drawing, *(each.memory_info().rss for each in serving)))
        kept = f"on {view}: {before} nodes, {after} after collection, with {listeners} listeners"
        print(f"{shots} shots: {_in_mb(used)}; {kept}", flush=True)  # so that a soak that is cut leaves what it saw
        return shots, *used

    return now


def _drawing(processes):
    return sum(each.memory_full_info().uss for each in processes if "--type=renderer" in each.cmdline())
