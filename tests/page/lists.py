"""Lists of the page among ten thousand recordings and jobs: the part `lists` of the bench of the page."""

from __future__ import annotations

import json
import os
import sqlite3
import statistics
import time
from datetime import datetime, timedelta

from platform_daemon.core.recordings.recording_index import INDEX
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.browser import open_view, visit
from tests.kit.command_line import wait_for
from tests.kit.rest import finished
from tests.kit.served import ready

MANY = 10_000
BEGIN = datetime(2026, 1, 1)


def lists(browser, data):
    """How long Recordings, Jobs and a trend take to show, among so many copies of one recording and of its job."""
    body = {**SHORT_JEWEL, "shots": 2, "sample": "J-01"}
    with ready(data) as daemon:
        one = finished(daemon, daemon.post("/acquisitions", body).headers["location"])["id"]
        wait_for(lambda: daemon.get("/recordings?specimen=J-01").json().get("items"), timeout=120)
    names = [f"acquisition-{BEGIN + timedelta(minutes=40 * k):%Y%m%dT%H%M%S}-{k:06x}" for k in range(MANY)]
    _copy_recordings(data / "recordings", one, names)
    _copy_jobs(data / "state.sqlite", one, names)
    with ready(data) as daemon:
        seen = visit(browser, daemon.address, "#/now")
        seen.page.get_by_text("Newest events").wait_for()
        for view, sign in (("recordings", "tbody tr"), ("jobs", "tbody tr"), ("specimens/J-01", ".plot canvas")):
            times_ms = [_time_ms(seen.page, view, sign) for _ in range(5)]
            wanted = "1000 ms" if "/" in view else "-"
            what = "Trend of a specimen" if "/" in view else view.capitalize()
            yield f"{what} shown, among {MANY}, median of 5", f"{statistics.median(times_ms):.0f} ms", wanted
        seen.context.close()


def _time_ms(page, view, sign):
    open_view(page, "now")
    began_s = time.monotonic()
    open_view(page, view)
    page.locator(f".{view.split('/')[0]} {sign}").first.wait_for(timeout=120_000)
    return 1000 * (time.monotonic() - began_s)


def _copy_recordings(folder, one, names):
    """Other names of one file, and their rows in the index, as if each had been looked at."""
    for name in names:
        os.link(folder / f"{one}.h5", folder / f"{name}.h5")
    with sqlite3.connect(folder / INDEX) as sql:
        columns = [row[1] for row in sql.execute("PRAGMA table_info(recordings)")]
        (row,) = sql.execute("SELECT * FROM recordings WHERE identifier = ?", (one,))
        ((shots, *point),) = sql.execute(
            "SELECT shots, temperature, field, fitted FROM points WHERE recording = ?", (one,)
        )
        for k, name in enumerate(names):
            at = f"{BEGIN + timedelta(minutes=40 * k):%Y-%m-%dT%H:%M:%S}.000+00:00"
            made = dict(zip(columns, row, strict=True)) | {"identifier": name, "file": f"{name}.h5", "begun": at}
            made["listed"] = json.dumps(json.loads(made["listed"]) | {"id": name})
            sql.execute(f"INSERT INTO recordings VALUES ({', '.join('?' * len(made))})", tuple(made.values()))
            sql.execute("INSERT INTO points VALUES (?, 0, ?, ?, ?, ?, ?)", (name, at, shots, *point))
    sql.close()


def _copy_jobs(path, one, names):
    with sqlite3.connect(path) as sql:
        ((state, record),) = sql.execute("SELECT state, record FROM jobs WHERE id = ?", (one,))
        made = [(name, state, record.replace(one, name)) for name in names]
        sql.executemany("INSERT INTO jobs VALUES (?, ?, ?)", made)
    sql.close()
