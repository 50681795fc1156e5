"""The records of a pipelined read, and our own account of it."""

from __future__ import annotations

import pytest

from drivers.errors import ShotRefused
from drivers.red_pitaya.stream import RECORD, RING_SAMPLES, Continuity, Record, filter_delay_samples

TRIGGERED, PLAYING = 8, 16


def record(status: int = TRIGGERED | PLAYING, lag: int = 700, first: int = 0, meanwhile: int = 3) -> Record:
    return Record.parse(RECORD.pack(status, lag, meanwhile, 0, 0, 255, 0), first)


def test_a_record_is_21_bytes():
    assert RECORD.size == 21


def test_the_delay_at_2048_is_24_samples_and_a_quarter():
    assert filter_delay_samples(2048) == pytest.approx(24.25, abs=2e-3)


@pytest.mark.parametrize(("bit", "name"), [(1, "overwritten"), (2, "corrupted"), (4, "lost_steps")])
def test_each_flag_has_its_bit(bit, name):
    assert record(TRIGGERED | bit).flags.names() == (name,)
    assert record().flags.names() == ()


def test_a_reader_a_ring_behind_is_flagged_even_if_the_card_does_not():
    assert record(lag=RING_SAMPLES + 1).flags.overwritten
    assert not record(lag=RING_SAMPLES).flags.overwritten


def test_a_whole_shot_passes():
    account = Continuity("card", 5000)
    for first in range(0, 4800, 608):
        account.check(record(first=first))
    account.check(record(TRIGGERED, first=5000))


def test_a_sequence_that_ended_while_the_chunk_was_sent_is_no_complaint():
    """The lag is that before the sending, the status that after it."""
    account = Continuity("card", 5000)
    account.check(record(TRIGGERED, first=3800, lag=600, meanwhile=700))
    account.check(record(TRIGGERED, first=3800, lag=1168, meanwhile=0))  # and the status a little later


def test_a_trigger_that_fell_refuses_the_shot():
    with pytest.raises(ShotRefused, match="trigger fell"):
        Continuity("card", 5000).check(record(PLAYING))


def test_a_recording_that_began_anew_refuses_the_shot():
    account = Continuity("card", 5000)
    account.check(record(first=2000))
    with pytest.raises(ShotRefused, match="restarted"):
        account.check(record(first=600))


def test_outputs_that_ended_early_refuse_the_shot():
    account = Continuity("card", 5000, 6000)
    account.check(record(first=300))
    with pytest.raises(ShotRefused, match="ended early"):
        account.check(record(TRIGGERED, first=1000))


def test_outputs_that_the_server_has_not_seen_begin_yet_are_no_complaint_for_a_while():
    account = Continuity("card", 50_000, 1500)
    for first in (0, 600, 1200, 6600):
        account.check(record(TRIGGERED, first=first))
    with pytest.raises(ShotRefused, match="have not started"):
        account.check(record(TRIGGERED, first=7200))
    account = Continuity("card", 50_000, 1500)
    account.check(record(TRIGGERED, first=0))
    account.check(record(TRIGGERED, first=6600))
    account.check(record(first=7200))
    account.check(record(first=12_000))


def test_outputs_that_never_began_refuse_a_short_shot_at_its_end():
    account = Continuity("card", 5000, 1500)
    account.check(record(TRIGGERED, first=1800))
    with pytest.raises(ShotRefused, match="have not started"):
        account.check(record(TRIGGERED, first=5400))
    account = Continuity("card", 5000, 1500)
    account.check(record(TRIGGERED, first=1800))
    account.check(record(first=2400))  # a busy server
    account.check(record(TRIGGERED, first=5400))


@pytest.mark.parametrize("which", ["lag", "meanwhile"])
def test_bytes_that_are_no_record_refuse_the_shot_instead_of_flagging_it(which):
    with pytest.raises(ShotRefused, match="makes no sense"):
        Continuity("card", 5000).check(record(**{which: 2**50}))
