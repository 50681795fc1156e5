"""Switch, amplifier, LNA, thermometer."""

import numpy as np
import pytest

from drivers.errors import DeviceFault, DeviceStateError, InputError
from drivers.tx_rx_switch import SwitchPosition
from tests.kit.simulated_bench import CLOCK, SWITCH, TX, Bench


def test_switch_rests_on_transmit_and_a_command_takes_its_dead_time():
    bench = Bench("thread")
    assert bench.switch.position() is SwitchPosition.TRANSMIT
    begin = bench.clock.monotonic_s()
    bench.switch.to_receive()
    assert bench.switch.position() is SwitchPosition.RECEIVE
    timing = bench.switch.timing()
    assert timing.dead_time_s <= bench.clock.monotonic_s() - begin <= timing.dead_time_s + timing.bounce_s + 1e-6
    bench.switch.to_transmit()
    assert bench.switch.position() is SwitchPosition.TRANSMIT
    bench.switch.close()
    bench.switch.close()


def test_position_follows_the_cards_line_through_a_shot():
    bench = Bench("thread")
    bench.start(bench.line_up(rx=6000))
    seen = []
    for samples in (TX, 100, 500, 6000 + SWITCH - 600):
        bench.card.read(samples)
        seen.append(bench.switch.position())
    assert seen == ["transmit", "moving", "receive", "moving"]
    bench.clock.sleep(3.1e-3)
    assert bench.switch.position() is SwitchPosition.TRANSMIT


def test_switch_takes_no_command_while_a_timeline_runs():
    bench = Bench("thread")
    bench.start(bench.line_up(rx=6000))
    with pytest.raises(DeviceStateError):
        bench.switch.to_receive()


def test_starting_before_the_contacts_are_home_loses_drive_as_in_reality():
    bench = Bench("thread")
    bench.switch.to_receive()
    bench.card.program(bench.line_up(rx=610))
    bench.amplifier.enable()
    bench.amplifier.unmute()
    bench.card.arm()
    bench.card.trigger()
    bench.card.read(10**6)
    stages = bench.backend.world.shot_simulator.result()[1].cuts
    assert stages[0].position is SwitchPosition.MOVING
    assert stages[0].stop_s == pytest.approx(3e-3)


def test_amplifier_starts_disabled_and_muted_and_needs_both_to_put_out_power():
    amplifier = Bench("thread").amplifier
    status = amplifier.status()
    assert (status.enabled, status.muted, status.fault, status.can_put_out_power) == (False, True, None, False)
    with pytest.raises(DeviceStateError):
        amplifier.unmute()
    amplifier.enable()
    assert amplifier.status().muted
    amplifier.unmute()
    assert amplifier.status().can_put_out_power
    amplifier.mute()
    amplifier.mute()
    assert not amplifier.status().can_put_out_power
    amplifier.disable()
    amplifier.disable()
    amplifier.close()
    assert not amplifier.status().enabled


def test_enabling_again_does_not_mute_a_working_amplifier():
    amplifier = Bench("thread").amplifier
    amplifier.enable()
    amplifier.unmute()
    amplifier.enable()
    assert amplifier.status().can_put_out_power


def test_muting_in_the_middle_of_the_burst_ends_the_drive_there():
    bench, whole = Bench("thread"), Bench("thread")
    whole.shot(rx=610)
    bench.start(bench.line_up(rx=610))
    head = bench.card.read(TX // 2)
    bench.amplifier.mute()
    bench.card.read(10**6)
    half, full = bench.truth()["amplitude_tx_end_rad"], whole.truth()["amplitude_tx_end_rad"]
    assert 0.3 * full < half < 0.7 * full
    kept = bench.backend.world.shot_simulator.result()[1].received.volts[:, : TX // 2]
    assert np.array_equal(head.volts, kept)


def test_amplifier_warms_up_with_use_and_cools_down_again():
    bench = Bench("thread", effects__temperature__enabled=False)
    cold = bench.amplifier.status().temperature_c
    assert cold == 22.0
    bench.amplifier.enable()
    bench.clock.sleep(600.0)
    warm = bench.amplifier.status().temperature_c
    assert 28.0 < warm < 31.0
    bench.amplifier.disable()
    bench.clock.sleep(3600.0)
    assert bench.amplifier.status().temperature_c == pytest.approx(22.0, abs=0.01)


def test_transmitting_heats_the_amplifier_by_its_share_of_the_energy():
    bench = Bench("jewel", effects__temperature__enabled=False, amplifier__loss_fraction=1000.0, amplifier__idle_w=0.0)
    bench.shot(rx=610)
    rise = bench.amplifier.status().temperature_c - 22.0
    assert rise * 60.0 / 1000.0 == pytest.approx(0.5 * 0.4866**2 * 4.0 * TX / CLOCK.rate_hz, rel=0.01)


def test_an_overheated_amplifier_trips_and_stays_down_until_it_is_cool_and_reset():
    bench = Bench("thread", effects__temperature__enabled=False, amplifier__trip_temperature_c=25.0)
    bench.amplifier.enable()
    bench.clock.sleep(600.0)
    bench.shot(rx=610)
    assert bench.amplifier.status().fault == "over-temperature"
    assert bench.truth()["peak_current_a"][0] == 0.0
    with pytest.raises(DeviceFault, match="over-temperature"):
        bench.amplifier.enable()
    with pytest.raises(DeviceFault, match="the fault stays: over-temperature"):
        bench.amplifier.reset_fault()
    assert bench.amplifier.status().fault == "over-temperature"
    bench.amplifier.disable()
    bench.clock.sleep(3600.0)
    assert bench.amplifier.status().fault == "over-temperature"
    bench.amplifier.reset_fault()
    status = bench.amplifier.status()
    assert (status.enabled, status.muted, status.fault) == (False, True, None)


def test_lna_takes_its_own_gains_only():
    lna = Bench("thread").lna
    assert lna.gains() == (1.0, 10.0, 40.0, 100.0)
    lna.set_gain(10.0)
    assert lna.gain() == 10.0
    with pytest.raises(InputError, match="12"):
        lna.set_gain(12.0)
    assert lna.gain() == 10.0
    lna.close()


def test_gain_stays_fixed_during_a_shot():
    bench = Bench("thread")
    bench.start(bench.line_up(rx=610))
    with pytest.raises(DeviceStateError):
        bench.lna.set_gain(10.0)


def test_thermometer_reads_the_temperature_with_its_own_noise_offset_and_resolution():
    bench = Bench("thread", effects__temperature__enabled=False, thermometer__offset_k=0.5)
    readings = np.array([bench.thermometer.temperature_c() for _ in range(400)])
    assert readings.mean() == pytest.approx(22.5, abs=0.005)
    assert readings.std() == pytest.approx(0.02, rel=0.15)
    assert readings * 100 == pytest.approx(np.rint(readings * 100))
    bench.thermometer.close()


def test_every_device_introduces_itself():
    bench = Bench("thread")
    for device in (bench.card, bench.switch, bench.amplifier, bench.lna):
        assert device.identity().manufacturer == "simulated"


def test_muting_after_the_burst_does_not_touch_the_shot():
    bench, calm = Bench("thread"), Bench("thread")
    bench.start(bench.line_up(rx=610))
    head = bench.card.read(TX + 10)
    before = bench.backend.world.shot_simulator.result()[1]
    bench.amplifier.disable()
    rest = bench.card.read(10**6)
    assert bench.backend.world.shot_simulator.result()[1] is before
    assert np.array_equal(np.concatenate([head.volts, rest.volts], axis=1), calm.shot(rx=610).astype(np.float32))
