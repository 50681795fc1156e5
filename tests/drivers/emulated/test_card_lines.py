"""Switch and amplifier that have no wire of their own keep the contracts, too."""

from __future__ import annotations

import pytest

from drivers.contract import AmplifierContract, PlatformContract, SwitchContract
from drivers.errors import ConfigError

SWITCH = 'tx_rx_switch={backend="red_pitaya", dead_time_s=3e-3, bounce_s=1e-3, settle_s=4e-3}'
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
