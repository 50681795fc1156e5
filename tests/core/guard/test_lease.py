"""When a sign of life is due, and when the outputs are not known to be off."""

from platform_daemon.core.guard.watch import (  # fmt: skip
    ALIVE,
    ENDED,
    LEASE_S,
    MAY_COME,
    OFF,
    OFF_LEASE_S,
    SWITCHING_OFF,
    Lease,
)


def test_nothing_is_due_before_power_may_come_and_after_outputs_are_off():
    lease = Lease()
    lease.heard(ALIVE + SWITCHING_OFF, 1.0)
    assert not lease.power
    lease.heard(MAY_COME, 2.0)
    assert lease.due_s == 2.0 + LEASE_S
    lease.heard(OFF, 3.0)
    assert not lease.power


def test_every_sign_of_life_buys_a_lease_and_switching_off_a_longer_one():
    lease = Lease()
    lease.heard(MAY_COME, 0.0)
    lease.heard(ALIVE, 5.0)
    assert lease.due_s == 5.0 + LEASE_S
    lease.heard(SWITCHING_OFF, 6.0)
    assert lease.due_s == 6.0 + OFF_LEASE_S
    assert lease.power


def test_an_owner_that_says_it_ends_has_no_power():
    lease = Lease()
    lease.heard(MAY_COME + ENDED, 0.0)
    assert lease.ended
    assert not lease.power


def test_a_word_nobody_knows_changes_nothing():
    lease = Lease()
    lease.heard(b"\x00?", 0.0)
    assert not lease.power
    assert not lease.ended
