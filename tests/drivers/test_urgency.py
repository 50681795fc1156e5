"""Who moves the shot goes first, and nobody else with it."""

import os
import types

from drivers.clock import SystemClock
from drivers.urgency import be_urgent, stand_in_line
from tests.kit.threads import in_a_thread


def policy():
    return os.sched_getscheduler(0)


def test_the_thread_goes_first_where_it_may_with_those_that_it_starts_until_they_stand_in_line():
    def later():
        inherited = policy()
        stand_in_line()
        return inherited, policy()

    def work():
        return be_urgent(SystemClock()), policy(), in_a_thread(later)

    why_not, own, (inherited, at_last) = in_a_thread(work)
    assert own == inherited == (os.SCHED_RR if why_not is None else os.SCHED_OTHER)
    assert at_last == policy() == os.SCHED_OTHER


def test_a_simulation_as_fast_as_it_goes_stands_in_line():
    clock = types.SimpleNamespace(realtime=False)
    assert in_a_thread(lambda: (be_urgent(clock), policy())) == ("its time does not pass by itself", os.SCHED_OTHER)


def test_who_may_not_is_told_why(monkeypatch):
    def refuse(*arguments):
        raise PermissionError(1, "not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    assert be_urgent(SystemClock()) == "not permitted"
