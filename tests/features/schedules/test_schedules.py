"""Calendar, ledger and scheduler, with a clock that the tests turn."""

import json
import random
import re
import sqlite3
import time
from collections import Counter
from datetime import UTC, datetime
from itertools import islice, pairwise

import pytest

from drivers.errors import DeviceLost, InputError, PlatformError
from platform_daemon.core.state.errors import RecordingInUse, StorageError
from platform_daemon.features.schedules import scheduler
from platform_daemon.features.schedules.calendar import Calendar
from platform_daemon.features.schedules.launcher import JobOutcome
from platform_daemon.features.schedules.ledger import Ledger
from platform_daemon.features.schedules.scheduler import Scheduler
from platform_daemon.features.schedules.schedules import Schedules
from platform_daemon.features.schedules.schema import ScheduleRequest

T0 = datetime(2026, 3, 1, tzinfo=UTC).timestamp()
DAY = 86_400.0


def asked(trigger, **others):
    work = {"kind": "acquisition", "request": {"resonator": "jewel", "shots": 1}}
    text = json.dumps({"name": "night", "trigger": trigger, "work": work} | others)
    return ScheduleRequest.model_validate_json(text)


class Owner:
    """A queue that keeps one job; `takes_s` long."""

    def __init__(self, clock, takes_s=10.0):
        self.clock, self.takes_s, self.jobs, self.next_fails = clock, takes_s, {}, None
        self.ends, self.mounted, self.began_with = "done", None, []
        self.priorities, self.stopped, self.asked_after = [], 0, []

    def planned_s(self, work):
        return self.takes_s

    def busy(self):
        return any(self.outcome(job).state == "running" for job in list(self.jobs)[-1:])

    def missing(self, work, *, surely):
        wanted = getattr(work.request, "resonator", None)
        return None if self.mounted in (None, wanted) else f"{wanted} has to be mounted"

    def new_id(self, work):
        return f"acquisition-{len(self.jobs)}"

    def stops(self):
        return self.stopped

    def launch(self, work, job, stops):
        if self.next_fails is not None:
            raise self.next_fails
        assert job not in self.jobs
        self.jobs[job] = self.clock()
        self.asked_after.append(stops)
        self.began_with.append(getattr(work.request, "resonator", None))
        self.priorities.append(work.request.priority)

    def outcome(self, job):
        if job not in self.jobs:
            return JobOutcome("unknown")
        running = abs(self.clock() - self.jobs[job]) < self.takes_s
        return JobOutcome("running" if running else self.ends, None, None if running else job)


THREAD = {"kind": "acquisition", "request": {"resonator": "thread"}}


class Bench:
    def __init__(self, folder, tell=lambda event: None):
        self.now, self.path = T0, folder / "schedules.db"
        self.owner = Owner(self.clock)
        self.all = Schedules(self.path, self.owner, self.clock, tell)
        self.all.open()

    def clock(self):
        return self.now

    def until(self, end, step=60.0):
        while self.now < end:
            self.now += step
            self.all.step()

    def restart(self):
        self.all.close()
        self.all = Schedules(self.path, self.owner, self.clock)
        self.all.open()

    def rows(self, identifier):
        return self.all.page(identifier, limit=100_000).items


@pytest.fixture
def bench(tmp_path):
    made = Bench(tmp_path)
    yield made
    made.all.close()


def local(trigger, start, count):
    calendar = Calendar(asked(trigger, start=start), T0)
    return [calendar.shown(due) for due in islice(calendar.after(calendar.start, inclusive=True), count)]


def test_a_time_that_daylight_saving_leaves_out_is_due_at_the_next_moment_and_a_doubled_one_once():
    berlin = {"cron": "30 2 * * *", "time_zone": "Europe/Berlin"}
    spring = local(berlin, "2026-03-28T00:00", 3)
    assert spring == ["2026-03-28T02:30:00+01:00", "2026-03-29T03:00:00+02:00", "2026-03-30T02:30:00+02:00"]
    autumn = local(berlin, "2026-10-24T00:00", 3)
    assert autumn == ["2026-10-24T02:30:00+02:00", "2026-10-25T02:30:00+02:00", "2026-10-26T02:30:00+01:00"]
    at = {"at": ["2026-03-29T02:30", "2026-10-25T02:30"], "time_zone": "Europe/Berlin"}
    assert local(at, "2026-03-01T00:00", 3) == ["2026-03-29T03:00:00+02:00", "2026-10-25T02:30:00+02:00"]


@pytest.mark.long
@pytest.mark.parametrize("zone", ["UTC", "Europe/Berlin", "America/New_York", "Australia/Lord_Howe", "Africa/Cairo"])
@pytest.mark.parametrize("cron", ["30 2 * * *", "*/30 * * * *", "0 1-3 * * *", "15 */2 * * 1-5"])
def test_the_instants_do_not_depend_on_where_one_begins_to_ask(zone, cron):
    calendar = Calendar(asked({"cron": cron, "time_zone": zone}, until="2027-03-05T00:00"), T0)
    everything = list(calendar.after(T0))
    assert all(a < b for a, b in pairwise(everything))
    chance = random.Random(1)
    for number in chance.sample(range(len(everything) - 3), 100):
        assert list(islice(calendar.after(everything[number]), 2)) == everything[number + 1 : number + 3]


@pytest.mark.parametrize(
    ("trigger", "others", "said"),
    [
        ({"cron": "0 0 30 2 *"}, {}, "trigger.cron"),
        ({"cron": "0 0 31 4,6 *"}, {}, "trigger.cron"),
        ({"cron": "every night"}, {}, "trigger.cron"),
        ({"cron": "0 2 * * *", "time_zone": "Europe/Atlantis"}, {}, "no time zone"),
        ({"cron": "0 2 * * *", "time_zone": "right/UTC"}, {}, "counts leap seconds"),
        ({"every_s": 60.0}, {"start": "2026-05-01T00:00", "until": "2026-04-01T00:00"}, "ends before it starts"),
        ({"every_s": 60.0, "cron": "0 2 * * *"}, {}, "one of every_s, cron and at"),
        ({}, {}, "one of every_s, cron and at"),
        ({"at": ["tomorrow"]}, {}, "is no time"),
        ({"at": ["2020-01-01T00:00"]}, {}, "never due"),
        ({"every_s": 5.0}, {}, "shorter than the work"),
    ],
)
def test_bad_input_is_told(bench, trigger, others, said):
    with pytest.raises(InputError, match=said):
        bench.all.add(asked(trigger, **others))
    with pytest.raises(InputError, match=said):
        bench.all.preview(asked(trigger, **others))
    assert bench.all.list() == ()


def test_a_night_runs_and_what_is_paused_is_skipped(bench):
    made = bench.all.add(asked({"every_s": 3600.0}))
    bench.until(T0 + 3.5 * 3600)
    bench.all.pause(made.id)
    bench.until(T0 + 5.5 * 3600)
    bench.all.resume(made.id)
    bench.until(T0 + 6.5 * 3600)
    states = [row.state for row in bench.rows(made.id)]
    assert states == ["late", *["run"] * 3, "skipped", "skipped", "run"]  # the first step came after 60 s
    assert len(bench.owner.jobs) == 5


def test_what_was_due_while_it_was_paused_and_the_daemon_away_is_skipped_and_nobody_misses_it(bench):
    made = bench.all.add(asked({"every_s": 3600.0}, grace_s=60.0))
    bench.until(T0 + 60.0)
    bench.all.pause(made.id)
    bench.now = T0 + 5.5 * 3600
    bench.restart()
    bench.all.step()
    assert {(row.state, row.reason) for row in bench.rows(made.id)[1:]} == {("skipped", "paused")}


def test_what_waits_when_its_schedule_is_removed_is_told_as_skipped(tmp_path):
    told = []
    bench = Bench(tmp_path, told.append)
    bench.owner.mounted = "thread"
    made = bench.all.add(asked({"every_s": 3600.0}, resonators=["jewel"]))
    bench.all.step()
    removed = bench.all.remove(made.id)
    assert (removed.active, removed.reason, removed.next_due) == (False, "removed", None)
    assert removed.request == made.request
    assert (told[-1].state, told[-1].reason) == ("skipped", "removed")
    bench.all.close()


@pytest.mark.parametrize(("before", "after"), [("UTC", "No/Where"), ("grace_s", "mercy_s")])
def test_a_schedule_that_another_version_has_left_does_not_keep_the_others_from_starting(bench, before, after):
    left = bench.all.add(asked({"every_s": 600.0}, name="left")).id
    bench.until(T0 + 700.0)
    bench.all.close()
    with sqlite3.connect(bench.path) as sql:
        sql.execute("UPDATE schedules SET request = replace(request, ?, ?)", (before, after))
    sql.close()
    bench.restart()
    made = bench.all.add(asked({"every_s": 600.0}))
    bench.until(T0 + 2200.0)
    assert [row.state for row in bench.rows(made.id)][:2] == ["late", "run"]
    assert {each.id for each in bench.all.list()} == {made.id, left}
    found = bench.all.get(left)
    assert not found.active
    assert re.search("cannot read it.*remove it and add it again|never due.*no time zone", found.reason, re.DOTALL)
    assert bench.rows(left)
    assert bench.all.remove(left).id == left
    assert [each.id for each in bench.all.list()] == [made.id]
    assert bench.rows(left)


@pytest.mark.parametrize(
    "trigger", [{"every_s": 1e12}, {"every_s": 3e8}, {"at": ["9999-12-31T23:59:59", "2027-01-01"]}]
)
def test_no_instant_is_so_late_that_it_has_no_date(bench, trigger):
    made = bench.all.add(asked(trigger))
    last = bench.all.preview(made.request, 10_000)[-1]
    assert last < "9999"
    bench.now = datetime.fromisoformat(last).timestamp() + 1.0
    bench.all.step()
    assert bench.all.get(made.id).next_due is None
    assert [each.id for each in bench.all.list()] == [made.id]


@pytest.mark.parametrize(
    ("policy", "states"), [("coalesce", Counter(missed=19, skipped=4, late=1, run=0)), ("run_all", None)]
)
def test_after_a_sleep_the_policy_decides(bench, policy, states):
    made = bench.all.add(asked({"every_s": 3600.0}, policy=policy, grace_s=5 * 3600.0 - 120))
    bench.now += 0.5
    bench.all.step()
    bench.until(T0 + 100.0)
    bench.now = T0 + DAY + 60
    bench.until(bench.now + 600)
    found = Counter(row.state for row in bench.rows(made.id))
    assert found["run"] == 1
    if policy == "coalesce":
        assert found == {"run": 1, "missed": 19, "skipped": 4, "late": 1}
    else:
        assert found == {"run": 1, "missed": 19, "late": 5}


def test_failures_in_a_row_and_a_stop_switch_it_off_until_it_is_resumed(bench):
    made = bench.all.add(asked({"every_s": 600.0}, max_failures=2))
    bench.owner.next_fails = DeviceLost("unplugged")
    bench.until(T0 + 3000)
    shown = bench.all.get(made.id)
    assert not shown.active
    assert "2 failures in a row" in shown.reason
    bench.owner.next_fails, bench.owner.ends = None, "cancelled"
    bench.all.resume(made.id)
    bench.until(T0 + 5000)
    assert bench.all.get(made.id).reason == "it was stopped"
    assert len(bench.owner.jobs) == 1


def test_of_several_the_highest_priority_begins_first(bench):
    low = bench.all.add(asked({"every_s": 3600.0}))
    high = bench.all.add(asked({"every_s": 3600.0}, priority=5))
    bench.until(T0 + 200)
    first, second = bench.rows(high.id)[0], bench.rows(low.id)[0]
    assert (first.job, second.job) == ("acquisition-0", "acquisition-1")
    assert bench.owner.priorities == [5, 0]


def test_a_scheduled_work_has_the_priority_of_its_schedule_and_none_of_its_own():
    with pytest.raises(ValueError, match="next to `work`"):
        asked({"every_s": 3600.0}, work={"kind": "self_test", "request": {"priority": 5}})


def test_leaping_clocks_leave_every_instant_in_the_ledger_once_and_start_none_twice(bench):
    made = bench.all.add(asked({"cron": "0 * * * *", "time_zone": "Europe/Berlin", "jitter_s": 30.0}, grace_s=1800.0))
    furthest, chance = T0, random.Random(3)
    for _ in range(400):
        leap = chance.choice([60.0, 600.0, 3600.0, -3600.0, DAY, -3653 * DAY])
        before, bench.now = bench.now, bench.now + leap
        furthest = max(furthest, bench.now)
        bench.all.step()
        if chance.random() < 0.2:
            bench.restart()
        if leap < -DAY:
            bench.now = before
    rows = bench.rows(made.id)
    calendar = Calendar(made.request, T0)
    expected = [due for due in islice(calendar.after(T0, inclusive=True), 10 * len(rows) + 10) if due <= furthest]
    assert [datetime.fromisoformat(row.due).timestamp() for row in rows] == expected
    jobs = [row.job for row in rows if row.job]
    assert len(set(jobs)) == len(jobs) == len(bench.owner.jobs) > 20


def test_a_daemon_that_ends_in_the_middle_of_a_step_judges_no_job_by_its_own_end(bench):
    made = bench.all.add(asked({"every_s": 3600.0}))
    bench.all.step()
    outcome = bench.owner.outcome

    def ends_meanwhile(job):
        bench.all.stop_starting()
        return JobOutcome("cancelled")  # as all that waits is, in a process that ends

    bench.owner.outcome = ends_meanwhile
    bench.all.step()
    bench.owner.outcome = outcome
    bench.restart()
    assert bench.all.get(made.id).active
    bench.until(T0 + 100.0)
    assert [row.state for row in bench.rows(made.id)] == ["run"]


def test_a_start_that_a_daemon_refuses_because_it_ends_is_made_by_the_next_one(bench):
    made = bench.all.add(asked({"every_s": 3600.0}))
    launch = bench.owner.launch

    def ends_meanwhile(work, job, stops):
        bench.all.stop_starting()
        raise PlatformError("the daemon is shutting down")

    bench.owner.launch = ends_meanwhile
    bench.all.step()
    bench.owner.launch = launch
    bench.restart()
    bench.until(T0 + 100.0)
    assert [row.state for row in bench.rows(made.id)] == ["run"]


def test_after_a_clock_that_was_years_ahead_resuming_makes_due_what_is_still_to_come(bench):
    nightly = bench.all.add(asked({"cron": "0 22 * * *"}, grace_s=600.0))
    bench.until(T0 + DAY)
    ran = [row.due for row in bench.rows(nightly.id) if row.state == "run"]
    assert len(ran) == 1
    bench.now += 3 * 365 * DAY
    bench.until(bench.now + DAY)  # one runs in that future
    late = bench.all.add(asked({"every_s": 3600.0}))
    bench.now = T0 + 1.5 * DAY
    assert bench.all.get(nightly.id).ahead_until > "2028"
    bench.until(T0 + 3 * DAY)
    assert len([row for row in bench.rows(nightly.id) if row.state == "run"]) == 2  # nothing new
    for each in (nightly, late):
        assert bench.all.resume(each.id).ahead_until is None
    bench.until(T0 + 5 * DAY)
    rows = bench.rows(nightly.id)
    assert len({row.due for row in rows}) == len(rows)
    assert len([row for row in rows if row.state in ("run", "late")]) == 4
    assert len([row for row in bench.rows(late.id) if row.state in ("run", "late")]) >= 47
    begun_ahead = [row for row in rows if row.state in ("run", "late") and row.due > "2028"]
    assert len(begun_ahead) == 1  # it is not forgotten, and not repeated
    restless = bench.all.resume(nightly.id)
    assert restless.ahead_until is None


def test_a_start_in_the_future_is_no_clock_that_was_ahead(bench):
    made = bench.all.add(asked({"every_s": 3600.0}, start="2030-01-01T00:00:00+00:00"))
    bench.until(T0 + 7200.0)
    assert bench.all.get(made.id).ahead_until is None


def test_a_ledger_cut_anywhere_is_refused_by_name_and_stays_as_it_is(bench):
    made = bench.all.add(asked({"every_s": 60.0}))
    bench.until(T0 + 20_000)
    bench.all.close()
    assert not bench.path.with_name("schedules.db-wal").exists()
    whole = bench.path.read_bytes()
    for size in (0, 1, 99, 100, 4095, 4096, len(whole) // 2, len(whole) - 1):
        bench.path.write_bytes(whole[:size])
        with pytest.raises(StorageError, match=r"schedules\.db.*damaged"):
            Schedules(bench.path, bench.owner, bench.clock).open()
        assert bench.path.read_bytes() == whole[:size]
    bench.path.write_bytes(whole)
    bench.restart()
    assert len(bench.rows(made.id)) > 300


def test_nothing_is_started_that_the_disk_does_not_take_and_it_is_tried_again(bench):
    made = bench.all.add(asked({"every_s": 7200.0}))
    other = sqlite3.connect(bench.path, isolation_level=None)
    other.execute("CREATE TRIGGER full BEFORE UPDATE OF started ON rows BEGIN SELECT RAISE(ABORT, 'full'); END")
    bench.now += 60
    with pytest.raises(StorageError, match="cannot be read or written"):
        bench.all.step()
    assert not bench.owner.jobs
    other.execute("DROP TRIGGER full")
    other.close()
    bench.until(T0 + 300)
    assert [row.state for row in bench.rows(made.id)] == ["late"]


def test_several_resonators_come_in_turn_whatever_lies_between(bench):
    made = bench.all.add(asked({"every_s": 600.0}, resonators=["thread", "jewel", "T-07"]))
    bench.until(T0 + 1900)
    bench.restart()
    bench.now += 7200  # away
    bench.until(bench.now + 1900)
    assert bench.owner.began_with == ["thread", "jewel", "T-07"] * 2 + ["thread", "jewel"]
    bench.all.run(made.id)
    bench.now += 1
    bench.all.step()
    assert bench.owner.began_with[-1] == "T-07"


def test_a_resonator_that_is_named_often_is_planned_once(bench, monkeypatch):
    planned = []
    monkeypatch.setattr(bench.owner, "planned_s", lambda work: planned.append(work.request.resonator) or 10.0)
    bench.all.add(asked({"every_s": 600.0}, resonators=["thread", "thread", "jewel"] * 300))
    assert planned == ["thread", "jewel"]
    bench.until(T0 + 1900)
    assert bench.owner.began_with == ["thread", "thread", "jewel", "thread"]


@pytest.mark.parametrize(
    "others", [{"resonators": ["jewel"] * 1001}, {"trigger": {"cron": f"{','.join(['0'] * 500)} 0 * * *"}}]
)
def test_what_would_take_long_at_each_look_is_not_kept(others):
    with pytest.raises(ValueError, match="at most 1000"):
        asked(**{"trigger": {"every_s": 600.0}, **others})


def test_resonators_come_in_turn_also_where_a_later_start_begins_first(bench):
    resonators = ["thread", "jewel", "T-07"]
    made = bench.all.add(asked({"every_s": 600.0, "jitter_s": 3600.0}, resonators=resonators, policy="run_all"))
    bench.until(T0 + 12 * 3600, step=30.0)
    rows = sorted((row for row in bench.rows(made.id) if row.job), key=lambda row: row.started)
    assert [row.due for row in rows] != sorted(row.due for row in rows)
    assert bench.owner.began_with == (resonators * len(rows))[: len(rows)]


def test_a_start_that_was_refused_has_no_job_and_its_resonator_had_its_turn(bench):
    made = bench.all.add(asked({"every_s": 600.0}, resonators=["thread", "jewel"]))
    bench.owner.next_fails = DeviceLost("unplugged")
    bench.until(T0 + 60)
    bench.owner.next_fails = None
    bench.until(T0 + 1260)
    refused = bench.rows(made.id)[0]
    assert (refused.state, refused.job) == ("failed", None)
    assert bench.owner.began_with == ["jewel", "thread"]


def test_where_a_person_has_to_mount_it_a_start_waits_and_says_so(tmp_path):
    told = []
    bench = Bench(tmp_path, told.append)
    bench.owner.mounted = "thread"
    made = bench.all.add(asked({"every_s": 3600.0}, resonators=["thread", "jewel"], grace_s=1800.0))
    other = bench.all.add(asked({"every_s": 3600.0}, work=THREAD))
    bench.until(T0 + 3700)
    assert [row.state for row in bench.rows(made.id)] == ["late", "due"]
    assert bench.rows(made.id)[-1].reason == "jewel has to be mounted"
    assert [row.state for row in bench.rows(other.id)] == ["late", "run"]  # nobody else waits for it
    assert [each.reason for each in told if each.state == "due"] == ["jewel has to be mounted"]
    bench.owner.mounted = "jewel"
    bench.until(T0 + 3900)
    assert bench.rows(made.id)[-1].state == "late"
    assert bench.owner.began_with[-1] == "jewel"
    bench.until(T0 + 9200)  # nobody comes
    last = bench.rows(made.id)[-1]
    assert (last.state, bench.owner.began_with.count("thread")) == ("missed", 1 + 2)  # the other schedule's, too
    assert "thread has to be mounted" in last.reason
    bench.all.close()


def test_a_start_by_hand_says_no_more_what_it_waited_for_once_that_is_there(tmp_path):
    told = []
    bench = Bench(tmp_path, told.append)
    bench.owner.mounted = "thread"
    made = bench.all.add(asked({"every_s": 86_400.0}, start="2099-01-01"))
    bench.all.run(made.id)
    bench.until(T0 + 4, step=1.0)
    assert bench.rows(made.id)[0].reason == "jewel has to be mounted"
    bench.owner.mounted = "jewel"
    bench.until(T0 + 60, step=1.0)
    assert (bench.rows(made.id)[0].state, bench.rows(made.id)[0].reason) == ("run", "requested")
    assert [each.reason for each in told if each.state == "due"] == ["jewel has to be mounted", None]
    bench.all.close()


def test_an_analysis_that_waits_for_the_index_asks_nobody_to_mount_anything(tmp_path):
    told = []
    bench = Bench(tmp_path, told.append)
    bench.owner.missing = lambda work, *, surely: "the index of the recordings is being made"
    made = bench.all.add(asked({"every_s": 3600.0}, work={"kind": "fit", "specimen": "J-01"}))
    bench.until(T0 + 60)
    assert bench.rows(made.id)[0].reason == "the index of the recordings is being made"
    assert told == []
    bench.all.close()


def test_a_schedule_for_one_resonator_does_not_measure_another_one_in_its_name(tmp_path):
    bench = Bench(tmp_path)
    bench.owner.mounted = "jewel"
    made = bench.all.add(asked({"every_s": 3600.0}, work=THREAD, grace_s=1800.0))
    bench.until(T0 + 3700)
    assert (bench.rows(made.id)[0].state, bench.owner.began_with) == ("missed", [])
    bench.owner.mounted = "thread"
    bench.until(T0 + 3800)
    assert bench.owner.began_with == ["thread"]
    bench.all.close()


def test_starts_of_years_without_the_daemon_do_not_wait_for_each_other(tmp_path, monkeypatch):
    monkeypatch.setattr(scheduler, "AT_ONCE", 50)
    ledger = Ledger(tmp_path / "schedules.db")
    bench = Bench(tmp_path)
    made = bench.all.add(asked({"every_s": 60.0}, grace_s=600.0))
    steps, most = Scheduler(ledger, bench.owner), 0
    while steps.step(T0 + 60_000.0):
        most = max(most, len(ledger.open_rows()))
    assert most <= 50 + 11
    states = Counter(row.state for row in bench.rows(made.id))
    assert (states["missed"], states["skipped"], states["started"]) == (990, 10, 1)
    ledger.close()
    bench.all.close()


def test_what_has_no_resonator_is_done_in_no_turn(bench):
    with pytest.raises(InputError, match="resonator of its own"):
        bench.all.add(asked({"every_s": 600.0}, resonators=["jewel"], work={"kind": "fit", "specimen": "x"}))


def test_a_stop_that_the_disk_does_not_take_starts_nothing_and_is_kept_once_it_does(bench):
    made = bench.all.add(asked({"every_s": 60.0}))
    other = sqlite3.connect(bench.path, isolation_level=None)
    other.execute("CREATE TRIGGER full BEFORE UPDATE OF off ON schedules BEGIN SELECT RAISE(ABORT, 'full'); END")
    assert "full" in str(bench.all.pause_all("everything was stopped"))
    bench.now += 120
    with pytest.raises(StorageError, match="cannot be read or written"):
        bench.all.step()
    with pytest.raises(StorageError, match="cannot be read or written"):
        bench.all.resume(made.id)
    assert not bench.owner.jobs
    bench.restart()  # with the disk still full: what was stopped stays so
    with pytest.raises(StorageError, match="full"):
        bench.all.step()
    assert not bench.owner.jobs
    assert bench.all.get(made.id).active is False
    other.execute("DROP TRIGGER full")
    other.close()
    bench.until(bench.now + 120)
    assert not bench.owner.jobs
    assert "everything was stopped" in bench.all.get(made.id).reason
    bench.restart()
    assert bench.all.get(made.id).active is False
    bench.all.resume(made.id)
    bench.until(bench.now + 120)
    assert bench.owner.jobs


def test_a_stop_waits_for_no_step_that_plans_and_what_that_begins_was_asked_for_before_it(bench):
    made = bench.all.add(asked({"every_s": 60.0}))
    bench.now += 61
    answered = []

    def stopped_meanwhile(work, *, surely):
        if not answered:
            bench.all.suspend("everything was stopped")
            bench.owner.stopped += 1
            began = time.monotonic()
            answered.append((bench.all.pause_all("everything was stopped"), time.monotonic() - began))

    bench.owner.missing = stopped_meanwhile
    bench.all.step()
    [(error, took_s)] = answered
    assert error is None
    assert took_s < 5  # the step would wait for ever for itself
    assert not bench.owner.jobs
    found = bench.all.get(made.id)
    assert (found.active, found.reason) == (False, "everything was stopped")


def test_a_start_is_given_the_stops_that_there_were_before_anybody_wanted_another_one(bench):
    bench.all.add(asked({"every_s": 60.0}))
    bench.now += 61
    bench.owner.stopped = 3
    bench.all.step()
    assert bench.owner.asked_after == [3]


def test_a_job_that_is_paused_before_it_begins_holds_no_other_schedule_back(bench):
    bench.all.add(asked({"every_s": 60.0}))
    other = bench.all.add(asked({"every_s": 60.0}, name="other"))
    bench.now += 61
    bench.all.step()
    assert len(bench.owner.jobs) == 1
    bench.owner.takes_s, bench.owner.ends = 0.0, "resting"
    bench.now += 1
    bench.all.step()
    assert len(bench.owner.jobs) == 2
    assert bench.rows(other.id)[-1].state == "started"


def test_a_ledger_whose_disk_is_gone_is_an_error_of_storage_and_a_stop_is_answered(bench):
    bench.all.add(asked({"every_s": 60.0}))
    other = sqlite3.connect(bench.path, isolation_level=None)
    other.execute("DROP TABLE rows")
    other.execute("ALTER TABLE schedules RENAME TO gone")
    other.close()
    assert "no such table" in str(bench.all.pause_all("everything was stopped"))
    for ask in (bench.all.step, bench.all.list):
        with pytest.raises(StorageError, match="no such table"):
            ask()


def test_a_start_by_hand_that_waits_is_stopped_with_everything_else(bench):
    made = bench.all.add(asked({"every_s": 3600.0}, work=THREAD))
    bench.owner.mounted = "jewel"
    bench.all.run(made.id)
    bench.all.step()  # somebody has to mount it
    assert bench.rows(made.id)[-1].state == "due"
    bench.all.pause_all("everything was stopped")
    bench.owner.mounted = "thread"
    bench.until(bench.now + 600, step=60.0)
    assert not bench.owner.jobs
    row = bench.rows(made.id)[-1]
    assert (row.state, row.reason) == ("skipped", "everything was stopped")
    bench.all.run(made.id)  # asked for after the stop
    bench.all.step()
    assert len(bench.owner.jobs) == 1


def test_a_start_by_hand_that_is_claimed_when_everything_is_stopped_is_not_made(bench):
    made = bench.all.add(asked({"every_s": 3600.0}))
    bench.all.run(made.id)
    claim = bench.owner.stops

    def stopped_meanwhile():
        bench.owner.stops = claim
        bench.all.suspend("everything was stopped")
        return claim()

    bench.owner.stops = stopped_meanwhile
    bench.until(bench.now + 60, step=10.0)
    assert not bench.owner.jobs
    row = bench.rows(made.id)[-1]
    assert (row.state, row.reason) == ("failed", "everything was stopped")


def test_a_start_by_hand_that_is_asked_for_after_a_stop_is_made(bench):
    made = bench.all.add(asked({"every_s": 3600.0}))
    bench.all.suspend("everything was stopped")  # which the ledger does not have yet
    bench.all.run(made.id)
    bench.all.step()
    assert len(bench.owner.jobs) == 1
    assert bench.all.get(made.id).reason == "everything was stopped"


def test_a_stop_while_the_daemon_ends_is_kept_for_the_next_one(bench):
    made = bench.all.add(asked({"every_s": 60.0}))
    bench.all.suspend("everything was stopped")
    bench.restart()
    assert bench.all.get(made.id).active is False
    bench.all.resume(made.id)
    bench.all.close()
    assert bench.all.pause_all("everything was stopped") is None
    bench.restart()
    assert bench.all.get(made.id).active is False


def test_a_leap_of_ten_years_leaves_a_bounded_number_of_rows(tmp_path):
    ledger = Ledger(tmp_path / "schedules.db")
    bench = Bench(tmp_path)
    made = bench.all.add(asked({"every_s": 60.0}, grace_s=600.0))
    paused = bench.all.add(asked({"cron": "* * * * *"}, grace_s=600.0))
    bench.all.pause(paused.id)
    now, told = T0 + 3653 * DAY, []
    steps = Scheduler(ledger, bench.owner, told.append)
    while steps.step(now):
        assert len(ledger.open_rows()) < 2 * scheduler.AT_ONCE + 100
    for schedule, state in ((made, "missed"), (paused, "skipped")):
        rows = ledger.rows(schedule.id, limit=10**6)
        assert len(rows) < scheduler.AT_ONCE + 100
        (whole,) = [row for row in rows if "others until" in (row.reason or "")]
        assert whole.state == state
        assert "5.3e+06 others until 2036-" in whole.reason
        assert sum(row.due > now - 1000 for row in rows) >= 10  # those that may still begin have rows of their own
        assert [event.state for event in told if event.reason == whole.reason] == [state]
    assert sum(row.state == "started" for row in ledger.rows(made.id, limit=10**6)) == 1
    ledger.close()
    bench.all.close()


def test_a_recording_that_is_in_use_does_not_switch_its_schedule_off(bench):
    made = bench.all.add(asked({"every_s": 60.0}))
    bench.owner.next_fails = RecordingInUse("another program has the file open for writing")
    bench.until(T0 + 70)
    assert "failed" in [row.state for row in bench.rows(made.id)]
    assert bench.all.get(made.id).active
