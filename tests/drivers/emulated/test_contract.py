"""The drivers of the real devices keep the contracts over emulated wires."""

from __future__ import annotations

import pytest

from drivers.contract import WHOLE_PLATFORM, CardContract

MASTER = (
    """{host="${io_cards.0.host}", command_port="${io_cards.0.command_port}", data_port="${io_cards.0.data_port}"}"""
)


@pytest.fixture(scope="module")
def platform(lab):
    built = lab.platform()
    yield built
    built.close()
    assert lab.violations() == ()


TestCard, TestSwitch, TestAmplifier, TestLna, TestPlatform = WHOLE_PLATFORM


class TestOneCard(CardContract):
    """The master alone, without a cluster."""

    @pytest.fixture(scope="class")
    @classmethod
    def card(cls, lab_of_its_own):
        lab = lab_of_its_own()
        built = lab.platform(f"io_card.boards=[{MASTER}]")
        yield built.card
        built.close()


class TestLinesOnPins(CardContract):
    """Gate and receiver by command."""

    @pytest.fixture(scope="class")
    @classmethod
    def card(cls, lab_of_its_own):
        lab = lab_of_its_own(
            'io_cards.pa_gate={board=0, output="DIO7_P"}', 'io_cards.rx_connect={board=1, output="DIO6_P"}'
        )
        built = lab.platform(
            "io_card.pin_delay_s=0.3",  # a busy test machine, not a lab's
            'io_card.lines.pa_gate={board=0, pin="DIO7_P"}',
            'io_card.lines.rx_connect={board=1, pin="DIO6_P"}',
        )
        yield built.card
        built.close()
        assert lab.violations() == ()
