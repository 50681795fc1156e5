"""The thread that runs a shot gets real-time priority, and no other process inherits it."""

import os
import types

from drivers.clock import SystemClock
from drivers.realtime import set_ordinary_priority, set_realtime_priority
from tests.kit.threads import in_a_thread


def policy():
    return os.sched_getscheduler(0)


def test_the_thread_gets_real_time_priority_where_permitted_with_those_it_starts_until_they_give_it_up():
    def later():
        inherited = policy()
        set_ordinary_priority()
        return inherited, policy()

    def work():
        return set_realtime_priority(SystemClock()), policy(), in_a_thread(later)

    why_not, own, (inherited, at_last) = in_a_thread(work)
    assert own == inherited == (os.SCHED_RR if why_not is None else os.SCHED_OTHER)
    assert at_last == policy() == os.SCHED_OTHER


def test_one_that_runs_when_nobody_else_does_stays_so_because_few_accounts_may_leave_that():
    def work():
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
        set_ordinary_priority()
        return policy()

    assert in_a_thread(work) == os.SCHED_IDLE


def test_a_simulation_without_pauses_keeps_ordinary_priority():
    clock = types.SimpleNamespace(realtime=False)
    assert in_a_thread(lambda: (set_realtime_priority(clock), policy())) == (
        "its time does not pass by itself",
        os.SCHED_OTHER,
    )


def test_the_reason_is_returned_where_the_priority_is_not_permitted(monkeypatch):
    def refuse(*arguments):
        raise PermissionError(1, "not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    assert set_realtime_priority(SystemClock()) == "not permitted"
