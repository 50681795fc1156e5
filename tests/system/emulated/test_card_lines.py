"""Switch and amplifier that have no wire of their own keep the contracts, too."""

from __future__ import annotations

import pytest

from drivers.card_lines.amplifier import PlainAmplifier
from drivers.conformance import AmplifierContract, PlatformContract, SwitchContract
from drivers.errors import ConfigError, DeviceFault
from platform_daemon.processes.assembly import start_engine
from tests.kit.acquisitions import acquire

SWITCH = 'tx_rx_switch={backend="red_pitaya", dead_time_s=3e-3, bounce_s=1e-3, settle_s=4e-3, no_readback=true}'
AMPLIFIER = 'power_amplifier={backend="red_pitaya", enable={board=1, pin="DIO7_N"}}'


@pytest.fixture(scope="class")
def platform(lab_of_its_own):
    lab = lab_of_its_own('amplifier.kind="line"')
    built = lab.platform(SWITCH, AMPLIFIER)
    yield built
    built.close()
    assert lab.violations() == ()


class TestSwitch(SwitchContract):
    pass


class TestAmplifier(AmplifierContract):
    pass


class TestPlatform(PlatformContract):
    pass


class Pins:
    """Of a card; the amplifier's fault output is joined to one of them."""

    def __init__(self, fault):
        self.levels = {(0, "DIO7_N"): False, (0, "DIO6_N"): fault}

    def pin(self, board, pin):
        return self.levels[board, pin]

    def set_pin(self, board, pin, high):
        self.levels[board, pin] = high


def test_an_amplifier_on_digital_lines_says_that_it_has_no_reset():
    pins = Pins(fault=True)
    amplifier = PlainAmplifier(pins, enable=(0, "DIO7_N"), fault=(0, "DIO6_N"))
    with pytest.raises(DeviceFault, match="mains off and on"):
        amplifier.enable()
    with pytest.raises(DeviceFault, match=r"has no reset.*mains off and on"):
        amplifier.reset_fault()
    pins.levels[0, "DIO6_N"] = False  # the cause was removed
    amplifier.reset_fault()
    amplifier.enable()
    amplifier.unmute()
    assert pins.levels[0, "DIO7_N"]


@pytest.mark.parametrize(
    ("override", "complaint"),
    [
        ('power_amplifier={backend="red_pitaya", enable={board=0, pin="AO2"}}', "no pin 'AO2'.*DIO7_P"),
        ('power_amplifier={backend="red_pitaya", enable={board=2, pin="DIO7_N"}}', "no board 2"),
        (
            'power_amplifier={backend="red_pitaya", enable={board=0, pin="DIO7_N"}, fault={board=0, pin="DIO7_N"}}',
            "DIO7_N is used twice",
        ),
    ],
)
def test_a_pin_that_cannot_be_is_refused(lab, override, complaint):
    with pytest.raises(ConfigError, match=complaint):
        lab.platform(override)


def test_a_stuck_relay_that_cannot_be_read_back_is_told_by_the_silence(lab_of_its_own, tmp_path):
    lab = lab_of_its_own('specimen="../resonators/jewel.toml"')
    engine = start_engine(lab.file(SWITCH))
    ask = {"resonator": "jewel", "sequence": {"rx_s": 0.6}}
    try:
        lab.control("inject", kind="switch_stuck")
        job = acquire(engine, tmp_path / "stuck.h5", **ask)
        assert any("no_signal" in warning and "switch" in warning for warning in job.warnings)
        lab.control("repair")
        job = acquire(engine, tmp_path / "free.h5", **ask)
        assert not any("cannot be fitted" in warning for warning in job.warnings)
    finally:
        engine.close()
