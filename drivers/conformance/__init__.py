"""The contracts as tests: the daemon may drive any device that passes them.

A third party certifies a driver with a file of its own, run by pytest:

    import pytest
    from drivers.conformance import CardContract, LnaContract

    class TestMyCard(CardContract):
        @pytest.fixture(scope="class")
        @classmethod
        def card(cls):
            card = MyCard("rp-f0a1b2")
            yield card
            card.close()

A class that offers the fixture `platform` (a `drivers.platform.Platform`) instead can use all of them, and
`PlatformContract`, which tests what the devices do together:

    TestCard, TestSwitch, TestAmplifier, TestLna, TestPlatform = WHOLE_PLATFORM

io_card.py          what every I/O card must do
repeatability.py    part of it: the same shot repeated, and a card whose host has vanished
incidents.py        part of it: stops, calibrated outputs, emergency input, strangers, slow answers
tx_rx_switch.py     what every Tx/Rx switch must do
power_amplifier.py  what every power amplifier must do
lna.py              what every low-noise amplifier must do
platform.py         what the devices of a platform must do together
timelines.py        the short timelines that they play

The tests put no power out: no burst is larger than a thousandth of full scale, the amplifier is never unmuted while its
gate is high, and everything is off afterwards.
"""

from drivers.conformance.io_card import CardContract
from drivers.conformance.lna import LnaContract
from drivers.conformance.platform import PlatformContract
from drivers.conformance.power_amplifier import AmplifierContract
from drivers.conformance.tx_rx_switch import SwitchContract

WHOLE_PLATFORM = (CardContract, SwitchContract, AmplifierContract, LnaContract, PlatformContract)

__all__ = ["WHOLE_PLATFORM", "AmplifierContract", "CardContract", "LnaContract", "PlatformContract", "SwitchContract"]
