"""Works through simulated minutes as fast as it can until it is killed; each start is a line of its own on the disk."""

import json
import os
import sqlite3
import sys
from pathlib import Path
from secrets import token_hex

from platform_daemon.features.schedules.launcher import JobOutcome
from platform_daemon.features.schedules.schedules import Schedules
from platform_daemon.features.schedules.schema import ScheduleRequest

folder = Path(sys.argv[1])
(folder / "jobs").mkdir(exist_ok=True)
clock_file = folder / "clock"
now = float(clock_file.read_text()) if clock_file.exists() and clock_file.read_text() else 1.8e9
started = os.open(folder / "started", os.O_WRONLY | os.O_CREAT | os.O_APPEND)


class Owner:
    def planned_s(self, work):
        return 1.0

    def busy(self):
        return False

    def missing(self, work, *, surely):
        return None

    def new_id(self, work):
        return f"acquisition-{token_hex(6)}"

    def stops(self):
        return 0

    def launch(self, work, job, stops):
        seen = sqlite3.connect(folder / "schedules.db")  # a connection of its own sees what is committed only
        rows = seen.execute("SELECT job, due FROM rows WHERE state = 'started'").fetchall()
        seen.close()
        assert [each for each, _ in rows] == [job], "it moves before the claim is committed"
        (folder / "jobs" / job).touch(exist_ok=False)
        os.write(started, f"{rows[0][1]}\n".encode())

    def outcome(self, job):
        return JobOutcome("done", None, job) if (folder / "jobs" / job).exists() else JobOutcome("unknown")


all_schedules = Schedules(folder / "schedules.db", Owner(), lambda: now)
all_schedules.open()
if not all_schedules.list():
    work = {"kind": "acquisition", "request": {"resonator": "jewel"}}
    asked = {"name": "minute", "trigger": {"every_s": 60.0}, "work": work, "policy": "run_all", "max_failures": 1000}
    all_schedules.add(ScheduleRequest.model_validate_json(json.dumps(asked)))
print("at work", flush=True)
while True:
    now += 60.0
    part = folder / "clock.part"
    part.write_text(repr(now))
    part.rename(clock_file)
    for _ in range(3):  # what a death has held up is made up for
        all_schedules.step()
