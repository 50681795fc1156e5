from itertools import pairwise

import pytest

from drivers.errors import ConfigError, DeviceFault, DeviceTimeout
from drivers.tx_rx_switch import SwitchPosition
from sim_backend.world.faults import DROPPED, KINDS
from tests.kit.simulated_bench import SWITCH, TX, Bench


def chunks(bench, rx=6000, size=1000):
    program = bench.line_up(rx=rx)
    bench.start(program)
    out = []
    while not out or out[-1].first_sample + out[-1].volts.shape[1] < program.total_samples:
        out.append(bench.card.read(size))
    return out


@pytest.mark.parametrize("kind", ["overwritten", "corrupted", "lost_steps"])
def test_a_flag_marks_exactly_one_chunk_of_the_chosen_shot(kind):
    bench = Bench("thread", **{f"faults__{kind}": [2]})
    marks = [[c.flags.names() for c in chunks(bench)] for _ in range(3)]
    assert [sum(bool(n) for n in shot) for shot in marks] == [0, 1, 0]
    assert (kind,) in marks[1]


def test_dropped_samples_show_as_a_jump_of_the_cards_own_count():
    bench = Bench("thread")
    bench.backend.world.faults.inject("dropped_samples", 1)
    parts = chunks(bench)
    gaps = [b.first_sample - a.first_sample - a.volts.shape[1] for a, b in pairwise(parts)]
    assert sorted(gaps)[-2:] == [0, DROPPED]
    whole = Bench("thread").shot(rx=6000)
    for part in parts:
        assert (part.volts == whole[:, part.first_sample : part.first_sample + part.volts.shape[1]]).all()
    assert sum(bool(g) for g in gaps) == 1


def test_a_timed_out_card_delivers_half_and_recovers_after_a_stop():
    bench = Bench("thread", faults__card_timeout=[1])
    bench.start(bench.line_up(rx=6000))
    bench.card.read(3000)
    for _ in range(2):
        with pytest.raises(DeviceTimeout):
            bench.card.read(3000)
    bench.card.stop()
    assert bench.shot(rx=600).shape[1] == TX + SWITCH + 600


def test_an_amplifier_trip_ends_the_burst_half_way_and_latches():
    bench = Bench("thread", faults__amplifier_trip=[1])
    program = bench.line_up(rx=600)
    bench.start(program)
    bench.card.read(TX // 4)
    assert bench.amplifier.status().fault is None
    bench.card.read(TX)
    assert bench.amplifier.status().fault == "over-current"
    bench.card.read(10**6)
    assert 5 < bench.truth()["amplitude_tx_end_deg"] < 16
    with pytest.raises(DeviceFault):
        bench.amplifier.enable()
    bench.amplifier.reset_fault()
    bench.shot(rx=600)
    assert bench.amplifier.status().fault is None


def test_a_stuck_switch_stays_where_it_is_and_says_so_until_repaired():
    bench = Bench("thread", faults__switch_stuck=[1])
    volts = bench.shot(rx=600)
    assert abs(volts[0, TX + SWITCH :]).max() < 0.01
    assert bench.switch.position() is SwitchPosition.TRANSMIT
    with pytest.raises(DeviceFault, match="not on receive"):
        bench.switch.to_receive()
    assert bench.backend.world.violations() == ()
    bench.backend.repair()
    bench.switch.to_receive()


def test_an_overload_in_the_receive_window_is_reported():
    bench = Bench("thread", faults__lna_overload=[1])
    volts = bench.shot(rx=6000)
    assert volts.max() == pytest.approx(1.0, abs=1e-4)
    assert bench.lna.overloaded()
    bench.lna.clear_overload()
    bench.shot(rx=600)
    assert not bench.lna.overloaded()


def test_faults_are_named_in_the_truth_of_their_shot_only():
    bench = Bench("thread", faults__corrupted=[1])
    bench.shot(rx=100)
    assert bench.truth()["faults"] == ["corrupted"]
    bench.shot(rx=100)
    assert bench.truth()["faults"] == []


def test_an_unknown_fault_is_refused_with_the_list_of_known_ones():
    with pytest.raises(ConfigError, match=KINDS[0]):
        Bench("thread").backend.world.faults.inject("gremlins", 1)


def test_repair_forgets_faults_to_come():
    bench = Bench("thread")
    bench.backend.world.faults.inject("corrupted", 1)
    bench.backend.repair()
    assert all(not c.flags.names() for c in chunks(bench))
