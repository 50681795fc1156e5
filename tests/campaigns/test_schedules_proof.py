"""Some months of `make schedules-proof`, and triggers of every kind against its oracle."""

import json
from datetime import UTC, datetime
from itertools import islice, takewhile

import pytest

from platform_daemon.features.schedules.calendar import Calendar
from platform_daemon.features.schedules.schema import ScheduleRequest
from tests.campaigns.schedules_proof.kills import scheduler_kills
from tests.campaigns.schedules_proof.oracle import due
from tests.campaigns.schedules_proof.years import PLANS, YEAR, Years

START = datetime(2026, 3, 20, tzinfo=UTC).timestamp()
TRIGGERS = {
    **{name: trigger for name, (trigger, _) in PLANS.items()},
    "Troll, two hours": {"cron": "30 */1 * * *", "time_zone": "Antarctica/Troll"},
    "named hours in Lord Howe": {"cron": "0,15,45 1-2 * * *", "time_zone": "Australia/Lord_Howe"},
    "Apia, Kiritimati": {"cron": "*/20 23 * * 0,6", "time_zone": "Pacific/Kiritimati"},
    "Tehran": {"cron": "0 0 21 3 *", "time_zone": "Asia/Tehran"},
    "day and weekday": {"cron": "10 4 13 * 5", "time_zone": "Europe/London"},
    "Cairo, at midnight": {"cron": "0 0 * * *", "time_zone": "Africa/Cairo"},
    "Azores": {"cron": "*/30 0-1 * * *", "time_zone": "Atlantic/Azores"},
    "every minute in Chatham": {"cron": "7-50/9 * 28-31 3-4,9-10 *", "time_zone": "Pacific/Chatham"},
}


@pytest.mark.parametrize("name", TRIGGERS)
def test_instants_of_two_years_are_those_of_the_oracle(name):
    end = START + 2 * YEAR
    asked = {"name": "x", "trigger": TRIGGERS[name], "work": {"kind": "fit", "specimen": "x"}}
    calendar = Calendar(ScheduleRequest.model_validate_json(json.dumps(asked)), START)
    found = list(takewhile(lambda at: at <= end, islice(calendar.after(START, inclusive=True), 10**6)))
    expected = due(TRIGGERS[name], START, end)
    assert len(found) == len(expected)
    assert found == expected


@pytest.mark.long
def test_every_instant_stands_in_the_ledger_once_whatever_the_clock_does(tmp_path):
    told = Years(tmp_path, 0.3, seed=3, step_s=3600.0).run()
    assert told.wrong == []
    assert sum(told.instants.values()) > 5000
    assert told.struck["deaths"] > 3


@pytest.mark.long
def test_kills_at_any_point_lose_no_start_and_double_none(tmp_path):
    found = scheduler_kills(tmp_path, 8)
    assert found.wrong == []
    assert found.instants > 8
