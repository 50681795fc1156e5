"""A short version of the campaign of drives."""

import pytest

from tests.campaigns.excitation import RECTANGLE, SINE, Rotor, from_rest, hamburg, move


@pytest.mark.long
def test_a_planned_drive_swings_the_hamburg_rotor_further_than_sine_and_chirp():
    reached = from_rest(Rotor(), Rotor(), 60)
    assert reached[SINE] > reached["chirp"] > reached["sine"]
    assert reached[SINE] == pytest.approx(21.5, abs=0.1)
    assert reached[RECTANGLE] > 1.2 * reached[SINE]


def test_the_chirp_of_the_first_frame_is_that_of_the_settings():
    tx = move(Rotor(), (0.0, 0.0), hamburg("Chirp", False, None, Rotor(), 30 / 814), 30 / 814)
    assert tx.largest_rad == pytest.approx(0.197, abs=0.01)
