"""`make page-bench`: how fast the page is and what it takes, beside series that run.

Measured in Debian's Chromium with software rendering, on daemons of its own with the simulated platform; the series
that browsers watch run in real time.  `--parts soak --journal FILE` measures one part, and keeps its rows for the page.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import psutil
from playwright.sync_api import sync_playwright

from tests.kit.browser import visit
from tests.kit.command_line import wait_for
from tests.kit.served import ready

from .lists import lists
from .soak import short_soak, soak

MOST_REAL = 10
"""Browsers beyond so many are clients that ask for the same: each real one is a process that draws on this computer."""
WATCHED_S = 40.0
SERIES = {"resonator": "jewel", "shots": 1000, "sequence": {"rx_s": 0.6, "pause_s": 0.4}, "window": None}
REAL_TIME = ("--set", 'backends.simulated.clock.mode="realtime"')
ABOUT = """Measured by `make page-bench` on {cores} cores in software rendering, at a load of {load:.1f}, with
that of other work. The series is of one shot a second, in real time; lateness is what the recording says of each
shot."""
WATCH = """() => {
  window.late = [];
  new MutationObserver(() => {
    const newest = document.querySelector('.now table time');
    if (newest && newest.dateTime !== window.seen) {
      window.seen = newest.dateTime;
      requestAnimationFrame(() => window.late.push(Date.now() - Date.parse(newest.dateTime)));
    }
  }).observe(document.querySelector('.now'), {childList: true, subtree: true, attributeFilter: ['datetime']});
}"""
PAINT = """() => [performance.getEntriesByName('first-contentful-paint')[0].startTime,
  performance.getEntriesByType('resource').concat(performance.getEntriesByType('navigation'))
    .filter(each => each.name.includes('/page/')).reduce((sum, each) => sum + each.transferSize, 0)]"""


def first_view(browser, daemon):
    """First paint and bytes of a browser that has never been here."""
    paints, sizes = [], []
    for _ in range(5):
        seen = visit(browser, daemon.address)
        seen.page.get_by_text("Newest events").wait_for()
        paint, size = seen.page.evaluate(PAINT)
        paints.append(paint)
        sizes.append(size)
        seen.context.close()
    yield "first paint, median of 5", f"{statistics.median(paints):.0f} ms", "500 ms"
    yield "bytes of the first view", f"{max(sizes) / 1000:.0f} kB", "120 kB"


def beside_a_series(browser, daemon, count):
    """From an event to its pixels, what the processes take, and how late the shots are, with so many browsers."""
    real = min(count, MOST_REAL)
    seen = [visit(browser, daemon.address) for _ in range(real)]
    for each in seen:
        each.page.get_by_text("Newest events").wait_for(timeout=120_000)
    page = seen[0].page if seen else browser.new_page()
    if seen:
        page.evaluate(WATCH)
    name = f"{count} browser{'' if count == 1 else 's'}" + (
        f", {count - real} of them simple clients" if count > real else ""
    )
    simple = max(count - real, min(count, 1))  # one draws nothing: how late events are at it is the daemon's share
    with clients(daemon.address, simple) as heard_ms:
        job = daemon.post("/acquisitions", SERIES).json()["id"]
        web = psutil.Process(daemon.pid("web"))
        before, began_s = (_busy_s([web]), _busy_s(_browser())), time.monotonic()
        page.wait_for_timeout(WATCHED_S * 1000)
        took_s = time.monotonic() - began_s
        server, browsers = (
            100 * (_busy_s(each) - was) / took_s for each, was in zip(([web], _browser()), before, strict=True)
        )
        late = page.evaluate("() => window.late ?? []")
        daemon.delete(f"/acquisitions/{job}")
        wait_for(lambda: daemon.get("/platform").json()["running"] is None)
    wait_for(lambda: daemon.get(f"/recordings/{job}").status_code == 200)
    shots_late_ms = sorted(
        1000 * (shot["late_s"] or 0) for shot in daemon.get(f"/recordings/{job}").json()["shots"][1:]
    )
    if len(late) > 1:
        yield f"event to pixel, p95, {name}", f"{_p95(late):.0f} ms ({len(late)} events)", "200 ms"
        yield f"event to a client that draws nothing, p95, beside {name}", f"{_p95(heard_ms):.0f} ms", "-"
    if count == 1:
        yield f"the browser itself, {name}", f"{browsers:.1f} % of a core", "3 %"
    yield f"web process, {name}", f"{server:.1f} % of a core", "-"
    middle, most = statistics.median(shots_late_ms), shots_late_ms[-1]
    wanted = "-" if count == 0 else "as with none"
    yield f"lateness of a shot, {name}", f"{middle:.0f} ms, {most:.0f} ms at most of {len(shots_late_ms)}", wanted
    for each in seen:
        each.context.close()


def against(browser, data, checkout):
    """The browser's share beside a series, and that of another checkout's page at the same time: how fast the computer
    is, and what else it does, is the same for both."""
    before = _browser()
    other = browser.browser_type.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
    with (
        ready(data, *REAL_TIME) as here,
        ready(data.with_name("other"), *REAL_TIME, checkout=checkout.resolve()) as there,
    ):
        _watch_series(other, there)
        theirs = [each for each in _browser() if each not in before]
        page = _watch_series(browser, here)
        both = [each for each in _browser() if each not in theirs], theirs
        began = [_busy_s(each) for each in both]
        page.wait_for_timeout(WATCHED_S * 1000)
        shares = [100 * (_busy_s(each) - was) / WATCHED_S for each, was in zip(both, began, strict=True)]
    other.close()
    yield "the browser itself, this page", f"{shares[0]:.1f} % of a core", "3 %"
    yield f"the browser itself, page of {checkout}, at the same time", f"{shares[1]:.1f} % of a core", "-"


def _watch_series(browser, daemon):
    page = visit(browser, daemon.address).page
    page.get_by_text("Newest events").wait_for(timeout=120_000)
    daemon.post("/acquisitions", SERIES)
    page.wait_for_timeout(4000)
    return page


def _browser():
    return [each for each in psutil.Process().children(recursive=True) if "chrom" in each.name()]


def _busy_s(processes):
    return sum(sum(each.cpu_times()[:2]) for each in processes)


def _p95(values):
    return statistics.quantiles(values, n=20)[-1]


@contextmanager
def clients(address, count):
    """A process of clients that read the events and ask for the state each second, as a page does.

    Yields how late each event was at one of them, ms, which is known when it has ended.
    """
    heard_ms: list[float] = []
    if not count:
        yield heard_ms
        return
    command = [sys.executable, "-m", "tests.page.clients", address, str(count)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    process.stdout.readline()  # all of them listen
    try:
        yield heard_ms
    finally:
        told, _ = process.communicate()
    heard_ms += json.loads(told)


def stop_and_halt(browser, daemon):
    """STOP with ten tabs open, and a web process that is halted."""
    seen = visit(browser, daemon.address)
    tabs = [seen.context.new_page() for _ in range(9)]
    for tab in tabs:
        tab.goto(seen.page.url)
    seen.page.get_by_text("Newest events").wait_for()
    took = []
    for _ in range(10):
        seen.page.bring_to_front()
        seen.page.wait_for_timeout(600)  # the tap that wakes a page does not count
        seen.page.get_by_role("button", name="STOP").click()
        seen.page.locator("#stopped.good").wait_for()
        took.append(int(seen.page.locator("#stopped").inner_text().split("(")[1].split()[0]))
    yield "STOP, answered, median of 10, ten tabs", f"{statistics.median(took):.0f} ms", "100 ms"
    daemon.kill("web", signal.SIGSTOP)
    began_s = time.monotonic()
    seen.page.locator("#fresh[data-old=true]").wait_for()
    yield "a halted daemon is seen after", f"{time.monotonic() - began_s:.1f} s", "3 s"
    daemon.kill("web", signal.SIGCONT)
    seen.context.close()


def on_a_daemon(measure, *keys):
    """A part that is measured on a daemon with these options."""

    def part(browser, data, options):
        with ready(data, *keys) as daemon:
            yield from measure(browser, daemon)

    return part


PARTS = {
    "first": on_a_daemon(first_view),
    **{str(count): on_a_daemon(partial(beside_a_series, count=count), *REAL_TIME) for count in (0, 1, 10, 50)},
    "stop": on_a_daemon(stop_and_halt),
    "against": lambda browser, data, options: against(browser, data, options.against),
    "lists": lambda browser, data, options: lists(browser, data),
    "soak-short": lambda browser, data, options: short_soak(browser, data),
    "soak": lambda browser, data, options: soak(browser, data, options.shots, 60 * options.minutes),
}
ASKED_FOR = ("against", "soak-short", "soak")
"""Parts that are measured only if they are named."""


def main() -> None:
    """Measure, print the rows of the table, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--page", type=Path, help="write the table there")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=[each for each in PARTS if each not in ASKED_FOR])
    parser.add_argument("--against", type=Path, help="another checkout, installed, for the part of that name")
    parser.add_argument("--journal", type=Path, help="rows of parts that were measured before, and of these")
    parser.add_argument("--shots", type=int, default=20_000, help="of the soak")
    parser.add_argument("--minutes", type=float, default=120.0, help="of the soak, at most")
    options = parser.parse_args()
    if "against" in options.parts and options.against is None:
        parser.error("--parts against needs --against FOLDER")
    kept = options.journal is not None and options.journal.exists()
    rows: dict[str, list[tuple[str, str, str]]] = json.loads(options.journal.read_text()) if kept else {}
    with sync_playwright() as p:
        browser = p.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        for part in options.parts:
            with tempfile.TemporaryDirectory() as folder:
                rows[part] = list(PARTS[part](browser, Path(folder) / "data", options))
            print("\n".join(map(" | ".join, rows[part])), flush=True)
            if options.journal is not None:
                options.journal.write_text(json.dumps(rows))
        browser.close()
    if options.page is not None:
        about = ABOUT.format(cores=psutil.cpu_count(), load=os.getloadavg()[2])
        lines = [f"| {' | '.join(row)} |" for part in PARTS for row in rows.get(part, ())]
        head = ["# The operator's page, measured", "", about, "", "| what | measured | wanted |", "|---|---|---|"]
        options.page.write_text("\n".join([*head, *lines, ""]))


if __name__ == "__main__":
    main()
