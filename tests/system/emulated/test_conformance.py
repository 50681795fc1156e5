"""The drivers of the real devices keep the contracts over emulated wires."""

from __future__ import annotations

import socket
import threading

import pytest

from drivers.conformance import WHOLE_PLATFORM, AmplifierContract, CardContract
from drivers.conformance.timelines import short_shot
from drivers.errors import DeviceStateError, ShotRefused
from drivers.red_pitaya.reader import Reader
from tests.kit.emulated_lab import lines_at

MASTER = (
    """{host="${io_cards.0.host}", command_port="${io_cards.0.command_port}", data_port="${io_cards.0.data_port}"}"""
)


@pytest.fixture(scope="module")
def platform(lab):
    built = lab.platform()
    yield built
    built.close()
    assert lab.violations() == ()


_, TestSwitch, _, TestLna, TestPlatform = WHOLE_PLATFORM


def calibrated(scale):
    """The emulated cards, with such a scale in their memory for all outputs."""
    both = f"dac_scale=[{scale}, {scale}], calibration_flags=0b11111111"
    boards = f'{{inputs=["x","y"], outputs=["x","y"], {both}}}, {{inputs=["z",""], outputs=["z",""], {both}}}'
    return f"io_cards.boards=[{boards}]"


class ShortCardContract(CardContract):
    """In short, on a busy computer."""

    stops = 3

    @pytest.fixture(scope="class")
    @classmethod
    def soon_s(cls):
        return 0.1


class TestCard(ShortCardContract):
    """Two cards; fixtures press the slave's emergency input and scan the master's port."""

    @pytest.fixture
    def abandon(self, lab):
        yield lab.cut_links
        lab.control("clear_faults")

    @pytest.fixture
    def emergency(self, lab):
        return lambda level: lab.control("instant_reset", board=1, level=level)

    @pytest.fixture(params=["command_port", "data_port"])
    def stranger(self, lab, request):
        at = lab.emulator.endpoints()["io_cards"][0]
        return lambda: socket.create_connection((at["host"], at[request.param]), timeout=2).close()


class TestAmplifier(AmplifierContract):
    @pytest.fixture
    def trip(self, lab):
        return lambda: lab.control("trip_amplifier")


class TestOneCard(ShortCardContract):
    """The master alone, without a cluster, its outputs calibrated."""

    @pytest.fixture(scope="class")
    @classmethod
    def card(cls, lab_of_its_own):
        lab = lab_of_its_own(calibrated(0.93))
        built = lab.platform(f"io_card.boards=[{MASTER}]")
        yield built.card
        built.close()

    def test_a_last_record_without_trigger_is_the_stop_not_a_bad_shot(self, card, monkeypatch):
        """The card drops the trigger before it drops the connection, and a record may be sent in between."""

        def late(reader):
            """Whole stop meanwhile."""
            stopper.start()
            stopper.join()
            raise ShotRefused("the trigger fell during the shot", where="board")

        monkeypatch.setattr(Reader, "_receive", late)
        stopper = threading.Thread(target=card.stop)
        card.program(short_shot(card.capabilities(), rx_s=0.5))
        card.arm()
        card.trigger()
        with pytest.raises(DeviceStateError):
            card.read(1000)


BUSY = "io_card.pin_delay_s=0.3"  # a busy test machine, not a lab's
ON_PINS = lines_at("0 DIO7_P", "1 DIO6_P")


@pytest.mark.long
class TestLinesOnPins(ShortCardContract):
    """Gate and receiver by command, outputs calibrated."""

    @pytest.fixture(scope="class")
    @classmethod
    def card(cls, lab_of_its_own):
        lab = lab_of_its_own(calibrated(1.1), *ON_PINS[0])
        built = lab.platform(BUSY, *ON_PINS[1])
        yield built.card
        built.close()
        assert lab.violations() == ()
