"""What every low-noise amplifier must do."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from drivers.errors import InputError
from drivers.lna import Lna
from drivers.platform import Platform


class LnaContract:
    """Offer the fixture `lna` or `platform`."""

    @pytest.fixture(scope="class")
    @classmethod
    def lna(cls, platform: Platform) -> Lna:
        """The LNA under test."""
        return platform.lna

    @pytest.fixture(autouse=True)
    def _as_it_was(self, lna: Lna) -> Iterator[None]:
        before = lna.gain()
        yield
        lna.set_gain(before)

    def test_it_says_who_it_is(self, lna: Lna) -> None:
        """Manufacturer or model at least."""
        assert lna.identity().manufacturer or lna.identity().model

    def test_its_gains_rise(self, lna: Lna) -> None:
        """Each once, all positive."""
        gains = lna.gains()
        assert gains
        assert gains[0] > 0
        assert list(gains) == sorted(set(gains))

    def test_every_gain_can_be_set_and_reads_back(self, lna: Lna) -> None:
        """Exactly."""
        for gain in lna.gains():
            lna.set_gain(gain)
            assert lna.gain() == gain

    def test_another_gain_is_refused_and_changes_nothing(self, lna: Lna) -> None:
        """It is never rounded to the next one."""
        before = lna.gain()
        for gain in (lna.gains()[-1] * 1.01, 0.0, -lna.gains()[0]):
            with pytest.raises(InputError):
                lna.set_gain(gain)
        assert lna.gain() == before

    def test_an_overload_can_be_cleared(self, lna: Lna) -> None:
        """With nothing at the input it does not come back."""
        lna.clear_overload()
        assert not lna.overloaded()
