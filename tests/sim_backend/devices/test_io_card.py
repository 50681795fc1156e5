import dataclasses
import threading
import time

import numpy as np
import pytest

from drivers.errors import DeviceStateError, InputError, SequenceRejected
from drivers.io_card import CardState
from drivers.timeline import Burst, SampleClock, Timeline
from tests.kit.simulated_bench import CLOCK, QUIET, SWITCH, TX, Bench, table


def test_life_cycle_goes_from_idle_through_running_to_idle():
    bench = Bench("thread")
    seen = [bench.card.state()]
    bench.card.program(bench.line_up(rx=610))
    seen.append(bench.card.state())
    bench.card.arm()
    seen.append(bench.card.state())
    bench.card.trigger()
    seen.append(bench.card.state())
    bench.card.read(10**6)
    seen.append(bench.card.state())
    bench.card.close()
    bench.card.close()
    assert [*seen, bench.card.state()] == ["idle", "programmed", "armed", "running", "idle", "closed"]


def test_commands_out_of_order_are_refused():
    card = Bench("thread").card
    for command in (card.arm, card.trigger, lambda: card.read(10)):
        with pytest.raises(DeviceStateError):
            command()


def test_a_running_card_takes_no_new_timeline():
    bench = Bench("thread")
    bench.start(bench.line_up(rx=610))
    with pytest.raises(DeviceStateError):
        bench.card.program(bench.line_up(rx=610))


def test_samples_are_counted_contiguous_float32_and_independent_of_the_chunk_size():
    whole = Bench("jewel").shot(rx=3000, chunk=10**6)
    parts = Bench("jewel").shot(rx=3000, chunk=997)
    assert np.array_equal(whole, parts)
    assert whole.shape == (3, TX + SWITCH + 3000)
    bench = Bench("jewel")
    bench.start(bench.line_up(rx=3000))
    chunk = bench.card.read(64)
    assert chunk.volts.dtype == np.float32
    assert chunk.volts.shape == (3, 64)
    assert chunk.flags.names() == ()


def test_reading_lets_world_time_pass_sample_by_sample():
    bench = Bench("thread")
    bench.start(bench.line_up(rx=6000))
    begin = bench.clock.monotonic_s()
    bench.card.read(1000)
    assert bench.clock.monotonic_s() - begin == pytest.approx(1000 / CLOCK.rate_hz)


def test_zero_samples_cannot_be_read():
    bench = Bench("thread")
    bench.start(bench.line_up(rx=610))
    with pytest.raises(InputError):
        bench.card.read(0)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"clock": SampleClock(125e6, 1024)}, "clock"),
        ({"bursts": (Burst(3, 0, 100, 212.0, 0.1),)}, "output 3"),
        ({"bursts": (Burst(0, 0, 100, 212.0, 1.5),)}, "1.5 V"),
        ({"bursts": (Burst(0, 0, 100, 212.0, 0.6), Burst(0, 50, 150, 300.0, 0.6))}, "1.2 V"),
        ({"bursts": (Burst(0, 0, 100, float("nan"), 0.1),)}, "nan Hz"),
        ({"bursts": (Burst(0, 0, 100, 212.0, float("nan")),)}, "nan V"),
        ({"bursts": (Burst(0, 0, 100, 40e3, 0.1),)}, "40000.0 Hz"),
        ({"rx_samples": 40_000_000}, "samples"),
    ],
)
def test_what_cannot_be_played_exactly_is_rejected_and_nothing_is_loaded(change, word):
    bench = Bench("thread")
    good = Timeline(CLOCK, TX, SWITCH, 610, (Burst(0, 0, 100, 212.0, 0.1),))
    with pytest.raises(SequenceRejected, match=word):
        bench.card.program(dataclasses.replace(good, **change))
    assert bench.card.state() is CardState.IDLE


def test_stop_ends_the_shot_and_the_rotor_goes_on_swinging_freely():
    bench = Bench("thread")
    bench.start(bench.line_up(rx=61035))
    bench.card.read(TX // 2)
    bench.card.stop()
    bench.card.stop()
    assert bench.card.state() is CardState.IDLE
    with pytest.raises(DeviceStateError):
        bench.card.read(10)
    truth = bench.truth()
    assert truth["amplitude_tx_end_rad"] is None
    assert 0.05 < truth["amplitude_end_rad"] < 0.3
    assert bench.backend.world.unit.rotor_state.phi_dot_rad_per_s != 0.0


def test_samples_before_a_stop_are_those_of_the_whole_shot():
    whole = Bench("thread").shot(rx=610)
    bench = Bench("thread")
    bench.start(bench.line_up(rx=610))
    head = bench.card.read(2000).volts
    bench.card.stop()
    assert np.array_equal(whole[:, :2000], head)
    assert np.array_equal(
        bench.backend.world.shot_simulator.result()[1].received.volts, whole[:, :2000].astype(np.float32)
    )


def test_stop_from_another_thread_wakes_a_blocked_read_in_real_time():
    bench = Bench("thread", clock__mode="realtime")
    bench.backend.warm_up()
    bench.start(bench.line_up(rx=61035 * 5))
    threading.Timer(0.3, bench.card.stop).start()
    begin = time.monotonic()
    with pytest.raises(DeviceStateError, match="stopped"):
        bench.card.read(10**6)
    assert time.monotonic() - begin < 2.0


def test_real_time_reading_takes_as_long_as_the_samples():
    bench = Bench("thread", clock__mode="realtime")
    bench.backend.warm_up()
    begin = time.monotonic()
    program = bench.line_up(rx=12207)
    bench.shot(rx=12207, chunk=2000)
    elapsed = time.monotonic() - begin
    assert program.duration_s <= elapsed < program.duration_s + 1.0


def test_card_tells_its_abilities():
    capabilities = Bench("thread").card.capabilities()
    assert (capabilities.inputs, capabilities.outputs) == (3, 3)
    assert capabilities.clock.rate_hz == 125e6 / 2048
    assert capabilities.input_full_scale_v == 1.0


def test_a_card_with_steps_plays_the_nearest_amplitude_that_its_register_holds():
    def recorded(volts, step_v):
        bench = Bench("thread", **QUIET)
        bench.card = bench.backend.io_card(
            {k: v for k, v in table()["io_card"].items() if k != "backend"} | {"output_step_v": step_v}
        )
        assert bench.card.capabilities().output_step_v == step_v
        plan = bench.line_up(rx=610)
        bench.start(dataclasses.replace(plan, bursts=(dataclasses.replace(plan.bursts[0], amplitude_v=volts),)))
        return bench.card.read(10**6).volts

    assert np.array_equal(recorded(0.0547, 0.01), recorded(0.05, 0.0))
    assert not np.array_equal(recorded(0.0547, 0.0), recorded(0.05, 0.0))
