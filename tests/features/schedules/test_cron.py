"""Cron expressions as docs/howto/nights-and-schedules.md says that they are taken."""

from itertools import islice

import pytest

from drivers.errors import InputError
from platform_daemon.features.schedules.calendar import Calendar, cron_in_words
from platform_daemon.features.schedules.schema import ScheduleRequest, TriggerRequest


def days(cron):
    """The first three dates after the middle of November 2026."""
    work = {"kind": "acquisition", "request": {"resonator": "thread"}}
    asked = {"name": "it", "trigger": {"cron": cron}, "work": work, "start": "2026-11-15T00:00"}
    calendar = Calendar(ScheduleRequest.model_validate(asked), 0.0)
    return [calendar.shown(due)[:10] for due in islice(calendar.after(calendar.start), 3)]


@pytest.mark.parametrize(
    ("cron", "found"),
    [
        ("0 22 * JAN mon-fri", ["2027-01-01", "2027-01-04", "2027-01-05"]),
        ("0 22 20 * 5", ["2026-11-20", "2026-11-27", "2026-12-04"]),  # either
        ("0 22 */2 * 5", ["2026-11-27", "2026-12-11", "2026-12-25"]),  # both
        ("0 22 L * *", ["2026-11-30", "2026-12-31", "2027-01-31"]),
        ("0 22 LW * *", ["2026-11-30", "2026-12-31", "2027-01-29"]),
        ("0 22 * * 5L", ["2026-11-27", "2026-12-25", "2027-01-29"]),
        ("0 22 * * MON#2", ["2026-12-14", "2027-01-11", "2027-02-08"]),
    ],
)
def test_what_is_taken(cron, found):
    assert days(cron) == found


@pytest.mark.parametrize("cron", ["@daily", "0 22 ? * *", "~ 22 * * *", "0 22 15W * *", "0 22 L-3 * *", "0 22 * * 1#6"])
def test_what_is_not(cron):
    with pytest.raises(InputError, match="cron"):
        days(cron)


@pytest.mark.parametrize(
    ("trigger", "words"),
    [
        ({"cron": "0 22 * * *"}, "At 22:00 every day"),
        ({"cron": "*/5 9-17 * * mon-fri"}, "Every fifth minute from 09:00 through 17:59 on Monday through Friday"),
        ({"cron": "0 6 * * MON#2"}, "At 06:00 on the second Monday of the month"),
        ({"every_s": 60}, None),
    ],
)
def test_an_expression_is_said_in_words(trigger, words):
    assert cron_in_words(TriggerRequest.model_validate(trigger)) == words
