"""On a card whose edges lie on a grid every planned edge does, and the plan says what became of the request."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from drivers.errors import SequenceRejected
from drivers.timeline import DigitalLine
from platform_daemon.core.settings import load_sequence
from sequences.compiler import TransmitSide, compile_shot
from sequences.request import SequenceRequest
from tests.kit.transmit_side import side

THREAD = load_sequence("thread")


def on_grid(step: int = 16, **card: float) -> TransmitSide:
    plain = side()
    return replace(plain, card=replace(plain.card, step_samples=step, **card))


def changed(**keys: object) -> SequenceRequest:
    return SequenceRequest(**{**THREAD.model_dump(), **keys})


@given(
    step=st.integers(1, 64),
    f_hz=st.floats(150.0, 300.0),
    periods=st.integers(5, 20),
    guard=st.integers(1, 100),
    switch_s=st.floats(0.013, 0.05),
    rx_s=st.floats(1.0, 3.0),
)
def test_every_edge_lies_on_the_grid_near_where_it_was_asked_for(step, f_hz, periods, guard, switch_s, rx_s):
    request = changed(f_tx_hz=f_hz, tx_periods=periods, guard_samples=guard, switch_s=switch_s, rx_s=rx_s)
    try:
        plan = compile_shot(request, on_grid(step))
    except SequenceRejected:
        assume(False)
    t, rate_hz = plan.timeline, plan.timeline.clock.rate_hz
    for part in (*t.bursts, *t.lines):
        assert part.start_sample % step == part.stop_sample % step == 0
    assert abs(t.tx_samples - periods * rate_hz / f_hz) <= step / 2 + 0.5
    assert abs(t.rx_samples - rx_s * rate_hz) <= step / 2 + 0.5
    assert 0 <= t.switch_samples - switch_s * rate_hz < step
    receive = next(e for e in t.lines if e.line is DigitalLine.RX_CONNECT)
    assert 0 <= receive.start_sample - t.tx_samples - guard < step
    assert plan.frequency_hz == pytest.approx(periods * rate_hz / t.tx_samples, rel=1e-12)


def test_the_plan_says_what_the_grid_made_of_the_frequency():
    plan = compile_shot(THREAD, on_grid(16))
    assert plan.timeline.tx_samples == 2880
    assert plan.summary()["f_tx_realised_hz"] == pytest.approx(211.9276, abs=1e-4)


def test_periods_too_short_for_the_grid_are_refused():
    with pytest.raises(SequenceRejected, match="steps of 4096 samples"):
        compile_shot(changed(f_tx_hz=2000.0, tx_periods=10), on_grid(4096))


def test_late_lines_need_a_longer_switch_window_and_guard():
    late = on_grid(1, line_delay_s=0.02)
    with pytest.raises(SequenceRejected, match="receiver would be connected while"):
        compile_shot(THREAD, late)
    with pytest.raises(SequenceRejected, match="before RX begins"):
        compile_shot(changed(guard_samples=1300), late)
    assert compile_shot(changed(guard_samples=1300, switch_s=0.06), late).timeline.switch_samples > 1300


@pytest.mark.parametrize("whose", ["min_guard_s", "amplifier_off_s"])
def test_the_least_guard_and_the_amplifiers_turn_off_time_are_kept_apart_from_the_receiver(whose):
    side = on_grid(1)
    rate_hz = side.card.clock.rate_hz
    guard_s = (THREAD.guard_samples + 10) / rate_hz
    if whose == "min_guard_s":
        side = replace(side, limits=side.limits.model_copy(update={whose: guard_s}))
    else:
        side = replace(side, amplifier_off_s=guard_s)
    enough = THREAD.guard_samples + 11
    with pytest.raises(SequenceRejected, match=rf"least guard.*guard_samples to {enough} or more"):
        compile_shot(THREAD, side)
    assert compile_shot(changed(guard_samples=enough), side)
