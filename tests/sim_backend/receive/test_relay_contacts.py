from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_backend.options import SwitchOptions
from sim_backend.receive.relay_contacts import MOVING, RECEIVE, TRANSMIT, Contacts
from tests.kit.simulated_bench import options

OPTIONS = SwitchOptions.model_validate(options()["switch"])


def rng():
    return np.random.default_rng(1)


def test_contacts_leave_at_once_arrive_after_the_dead_time_and_bounce_within_theirs():
    contacts = Contacts(OPTIONS).command(1.0, RECEIVE, rng())
    assert contacts.position(0.999) is TRANSMIT
    assert contacts.position(1.0) is MOVING
    assert contacts.position(1.0 + 2.99e-3) is MOVING
    assert contacts.position(1.0 + 3.001e-3) is RECEIVE
    assert contacts.arrival_s() <= 1.0 + OPTIONS.dead_time_s + OPTIONS.bounce_s
    assert contacts.position(contacts.arrival_s()) is RECEIVE
    closings = [p for t, p in contacts.changes if t > 1.0]
    assert closings == [RECEIVE] + [MOVING, RECEIVE] * OPTIONS.bounces


def test_a_command_to_where_they_are_changes_nothing():
    contacts = Contacts(OPTIONS)
    assert contacts.command(1.0, TRANSMIT, rng()) is contacts


def test_a_reversal_while_moving_starts_a_new_dead_time():
    contacts = Contacts(OPTIONS).command(1.0, RECEIVE, rng()).command(1.001, TRANSMIT, rng())
    assert contacts.position(1.0035) is MOVING
    assert contacts.position(1.00401) is TRANSMIT
    assert RECEIVE not in {p for _, p in contacts.changes}


def test_stuck_contacts_ignore_commands():
    stuck = Contacts(OPTIONS).with_stuck(True)
    assert stuck.command(1.0, RECEIVE, rng()).position(2.0) is TRANSMIT


@given(st.lists(st.tuples(st.floats(1e-4, 0.02), st.sampled_from([TRANSMIT, RECEIVE])), max_size=6))
def test_spans_cover_time_and_never_go_from_side_to_side_without_moving(steps):
    contacts, t = Contacts(OPTIONS), 0.0
    for wait, target in steps:
        t += wait
        contacts = contacts.command(t, target, rng())
    spans = contacts.spans(0.0, 0.2)
    assert spans[0][0] == 0.0
    assert spans[-1][1] == 0.2
    for (_, stop, before), (start, _, following) in pairwise(spans):
        assert stop == start
        assert {before, following} != {TRANSMIT, RECEIVE}


def test_shifting_moves_the_time_zero():
    contacts = Contacts(OPTIONS).command(5.0, RECEIVE, rng()).shifted(-5.0)
    assert contacts.position(0.0) is MOVING
    assert contacts.arrival_s() == pytest.approx(OPTIONS.dead_time_s + OPTIONS.bounce_s, abs=1e-3)


@given(st.floats(0.0, 1.1), st.floats(0.0, 0.3))
def test_what_is_forgotten_changes_nothing_after_it(since_s, later_s):
    contacts = Contacts(OPTIONS)
    for k in range(10):
        contacts = contacts.command(0.1 * k, (RECEIVE, TRANSMIT)[k % 2], rng())
    forgetful = contacts.since(since_s)
    assert forgetful.position(since_s + later_s) is contacts.position(since_s + later_s)
    assert forgetful.spans(since_s, since_s + 0.4) == contacts.spans(since_s, since_s + 0.4)
    assert len(forgetful.changes) <= len(contacts.changes)
