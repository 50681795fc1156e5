"""What happens to an I/O card in a lab, as the server of a real one taught; part of `CardContract`.

Stops at any moment, calibrated outputs, its emergency input, strangers on its port, slow answers.
"""

from __future__ import annotations

import contextlib
import random
import statistics
import threading
import time
from collections.abc import Callable
from dataclasses import replace

import pytest

from drivers.conformance.repeatability import alike, loudness
from drivers.conformance.timelines import collect, short_shot
from drivers.errors import DeviceFault, DeviceStateError
from drivers.io_card import CardState, IoCard

SOON_S = 0.02
TRIES = 5
EMERGENCY_S = 0.2


class IncidentContract:
    """Offer the fixtures `emergency` and `stranger` if there is a way; `stops`: how many in each state."""

    stops = 100

    @pytest.fixture(scope="class")
    @classmethod
    def soon_s(cls) -> float:
        """How soon after the trigger the first sample must be there, s; larger for a slow link or a busy computer."""
        return SOON_S

    @pytest.fixture
    def emergency(self) -> Callable[[bool], None] | None:
        """Press (True) or release the card's emergency input; None: that cannot be done here."""
        return None

    @pytest.fixture
    def stranger(self) -> Callable[[], None] | None:
        """Connect to a port of the card and go, as a port scan does; None: it has none."""
        return None

    def test_stop_at_any_moment_and_the_next_shot_is_whole(self, card: IoCard) -> None:
        """Idle, programmed, armed, running and over, in turns: the card must never hang."""
        timeline = short_shot(card.capabilities(), rx_s=0.03)
        steps = [lambda: card.program(timeline), card.arm, card.trigger, lambda: card.read(500)]
        states = len(steps) + 1
        for count in range(states * self.stops):
            for step in steps[: count % states]:
                step()
            card.stop()
            assert card.state() is CardState.IDLE
        assert sum(c.volts.shape[1] for c in collect(card, timeline, 5000)) == timeline.total_samples

    def test_a_stop_beside_commands_ends_them_and_another_shot_is_whole(self, card: IoCard) -> None:
        """From another thread, while the shot is prepared, triggered and read: whatever comes first, the card is idle
        then, nothing plays, and a shot at other times is whole."""
        can = card.capabilities()
        chance = random.Random(1)
        timeline, other = short_shot(can, rx_s=0.03), short_shot(can, rx_s=0.05)

        def shoot() -> None:
            """One shot, or as much of it as the stop leaves."""
            with contextlib.suppress(DeviceStateError):
                card.program(timeline)
                card.arm()
                card.trigger()
                card.read(timeline.total_samples)

        began_s = time.monotonic()
        shoot()
        lasts_s = time.monotonic() - began_s
        for _ in range(max(3, self.stops // 4)):
            shooting = threading.Thread(target=shoot)
            shooting.start()
            time.sleep(chance.uniform(0.0, lasts_s))
            card.stop()
            shooting.join()
            card.stop()  # commands that came after the first stop
            assert card.state() is CardState.IDLE
            assert sum(c.volts.shape[1] for c in collect(card, other, 5000)) == other.total_samples

    def test_every_amplitude_up_to_full_scale_can_be_armed(self, card: IoCard) -> None:
        """Also where outputs are calibrated: what is read back is compared in the right unit, to a step.

        Nothing is triggered, so nothing is put out.
        """
        can = card.capabilities()
        good = short_shot(can)
        for share in (1e-4, 0.1, 1 / 3, 0.5, 0.777, 0.95, 1.0):
            volts = share * can.output_full_scale_v
            card.program(replace(good, bursts=tuple(replace(b, amplitude_v=volts) for b in good.bursts)))
            card.arm()
            card.stop()

    def test_the_first_samples_come_soon_after_the_trigger(self, card: IoCard, soon_s: float) -> None:
        """A driver that waits for a delayed acknowledgement somewhere loses 40 ms each time."""
        timeline = short_shot(card.capabilities())
        waited = []
        for _ in range(TRIES):
            card.program(timeline)
            card.arm()
            begun_s = time.monotonic()
            card.trigger()
            card.read(1)
            waited.append(time.monotonic() - begun_s)
            card.stop()
        assert statistics.median(waited) < soon_s

    def test_the_emergency_input_ends_a_shot_with_a_fault(
        self, card: IoCard, emergency: Callable[[bool], None] | None
    ) -> None:
        """Named at once, not at the end of the shot; afterwards the card shoots again."""
        if emergency is None:
            pytest.skip("the card has no emergency input, or no fixture presses it")
        timeline = short_shot(card.capabilities(), rx_s=1.0)
        card.program(timeline)
        card.arm()
        card.trigger()
        done = card.read(100).volts.shape[1]
        emergency(True)
        begun_s = time.monotonic()

        def rest() -> None:
            """To the end of the shot."""
            left = timeline.total_samples - done
            while left:
                left -= card.read(min(100, left)).volts.shape[1]

        with pytest.raises(DeviceFault):
            rest()
        assert time.monotonic() - begun_s < EMERGENCY_S
        card.stop()
        emergency(False)
        assert sum(c.volts.shape[1] for c in collect(card, timeline, 5000)) == timeline.total_samples

    def test_the_emergency_input_at_the_very_end_of_a_shot_leaves_the_next_one_good(
        self, card: IoCard, emergency: Callable[[bool], None] | None
    ) -> None:
        """Pressed when all but the last samples have come, and released before the stop."""
        if emergency is None:
            pytest.skip("the card has no emergency input, or no fixture presses it")
        timeline = short_shot(card.capabilities(), rx_s=0.1)
        before = loudness(card, timeline)
        card.program(timeline)
        card.arm()
        card.trigger()
        card.read(timeline.total_samples - 100)
        emergency(True)
        with contextlib.suppress(DeviceFault):
            card.read(100)
        emergency(False)
        card.stop()
        for _ in range(2):
            alike(before, loudness(card, timeline))

    def test_a_stranger_on_the_port_costs_no_shot_after_a_stop(
        self, card: IoCard, stranger: Callable[[], None] | None
    ) -> None:
        """Another client connects to the card and disconnects."""
        if stranger is None:
            pytest.skip("the card has no port, or no fixture connects to it")
        timeline = short_shot(card.capabilities())
        card.program(timeline)
        card.arm()
        stranger()
        card.stop()
        assert sum(c.volts.shape[1] for c in collect(card, timeline, 5000)) == timeline.total_samples
