"""The same shot repeated, as a series does, and the state in which a card is left when its host vanishes.

Part of `CardContract`: each repetition must be as good as the first, and the card must not play its memory again
without its host.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.conformance.timelines import collect, short_shot
from drivers.io_card import CardState, IoCard
from drivers.timeline import Timeline

ALIKE = 2.0  # largest ratio of two amplitudes: they contain noise and interference of the lab
OVER_S = 1.0  # from the end of a shot until all must be off, whichever process lives
WATCHED_S = 5.0


class RepeatabilityContract:
    """Offer the fixture `abandon` if there is a way."""

    @pytest.fixture
    def abandon(self) -> Callable[[], Callable[[], bool]] | None:
        """Cut the card off from this computer, without a word; what it returns says whether outputs or gate are on.

        None: that cannot be done here.  The fixture joins them again at its end.
        """
        return None

    def test_the_same_shot_again_is_as_good_as_the_first(self, card: IoCard) -> None:
        """Without a stop in between."""
        timeline = short_shot(card.capabilities())
        first = loudness(card, timeline)
        for _ in range(3):
            alike(first, loudness(card, timeline))

    def test_another_shot_in_between_leaves_nothing_behind(self, card: IoCard) -> None:
        """Of another length, without power, louder: the one after it is the first again."""
        can = card.capabilities()
        timeline = short_shot(can)
        louder = replace(timeline, bursts=tuple(replace(b, amplitude_v=4 * b.amplitude_v) for b in timeline.bursts))
        first = loudness(card, timeline)
        for other in (short_shot(can, rx_s=0.05), short_shot(can, bursts=False), louder):
            loudness(card, other)
            alike(first, loudness(card, timeline))

    @pytest.mark.parametrize("state", list(CardState)[:4])
    def test_a_stop_in_between_leaves_the_next_shot_whole(self, card: IoCard, state: CardState) -> None:
        """Stopped once, and once more, wherever the repetition is."""
        timeline = short_shot(card.capabilities())
        first = loudness(card, timeline)
        for stops in (1, 2):
            steps = [lambda: card.program(timeline), card.arm, card.trigger]
            for step in steps[: list(CardState).index(state)]:
                step()
            for _ in range(stops):
                card.stop()
            assert card.state() is CardState.IDLE
            alike(first, loudness(card, timeline))

    def test_nothing_is_played_when_the_host_is_gone(
        self, card: IoCard, abandon: Callable[[], Callable[[], bool]] | None
    ) -> None:
        """In the middle of a shot that was played before: it ends by itself, and does not come again."""
        if abandon is None:
            pytest.skip("no fixture cuts the card off and watches its outputs")
        timeline = short_shot(card.capabilities())
        loudness(card, timeline)
        card.program(timeline)
        card.arm()
        card.trigger()
        on = abandon()
        time.sleep(timeline.duration_s + OVER_S)
        watched_until_s = time.monotonic() + WATCHED_S
        while time.monotonic() < watched_until_s:
            assert not on()
            time.sleep(1e-3)


def loudness(card: IoCard, timeline: Timeline) -> NDArray[np.float64]:
    """Root mean square of each input in the TX window of one whole shot, (inputs,) V."""
    chunks = collect(card, timeline, 5000)
    volts = np.concatenate([c.volts for c in chunks], axis=1)
    assert volts.shape[1] == timeline.total_samples
    assert not any(c.flags.names() for c in chunks)
    sent: NDArray[np.float64] = np.sqrt(np.mean(np.square(volts[:, : timeline.tx_samples], dtype=np.float64), axis=1))
    return sent


def alike(first: NDArray[np.float64], later: NDArray[np.float64]) -> None:
    """Raises AssertionError if one shot is louder than the other."""
    assert np.all(later <= ALIKE * first + 1e-6)
    assert np.all(first <= ALIKE * later + 1e-6)
