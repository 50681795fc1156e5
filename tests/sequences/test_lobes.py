"""Half periods of the field: constant frequency, chirps, either shape, from any phase."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from platform_daemon.core.settings import load_sequence
from sequences.lobes import Lobes, unplanned_lobes
from sequences.request import SequenceRequest

THREAD = load_sequence("thread").model_dump()
TX_S = 0.1


def request(**keys: object) -> SequenceRequest:
    return SequenceRequest(**{**THREAD, **keys})


@settings(max_examples=60, deadline=None)
@given(f=st.floats(50, 2000), chirp=st.floats(-0.4, 0.8), phase=st.floats(-7, 7))
def test_a_chirp_is_a_sine_whose_frequency_is_linear_in_time(f, chirp, phase):
    asked = request(f_tx_hz=f, chirp_hz=chirp * f, phase_rad=phase)
    lobes = unplanned_lobes(asked, f, TX_S)
    t = np.linspace(max(lobes.zeros_s[0], 0.0), lobes.zeros_s[-1], 4000)
    turned = 2 * np.pi * (f * t + 0.5 * chirp * f / TX_S * t**2) + phase
    # Inside a half period the sine keeps its frequency: what it is off by stays below the change within that.
    off = np.max(np.abs(lobes.at(t) - np.sin(turned)))
    assert off < 1e-6 + 2.0 * abs(chirp) / max(f * TX_S * (1 - 0.4), 1.0)
    assert lobes.zeros_s[0] <= 1e-12
    assert lobes.zeros_s[-1] <= TX_S * (1 + 1e-9)
    assert np.all(
        np.sign(np.sin(turned[1:-1]))[np.abs(np.sin(turned[1:-1])) > 1e-3]
        == np.sign(lobes.at(t[1:-1]))[np.abs(np.sin(turned[1:-1])) > 1e-3]
    )


def test_a_rectangle_fills_its_duty_in_the_middle_of_every_half_period():
    lobes = unplanned_lobes(request(f_tx_hz=200.0, waveform="rectangle", duty=0.7), 200.0, TX_S)
    t = np.arange(100_000) / 1e6
    field = lobes.at(t)
    assert set(np.unique(field)) == {-1.0, 0.0, 1.0}
    assert np.mean(np.abs(field)) == pytest.approx(0.7, abs=1e-3)
    assert field[1250] == 1.0
    assert field[100] == 0.0


def test_what_does_not_end_in_tx_is_left_out():
    lobes = Lobes(np.array([0.0, 0.4, 0.8, 1.2]), -1)
    kept = lobes.until(1.0)
    assert len(kept) == 2
    assert kept.at(np.array([0.2, 0.6, 1.1])).tolist() == pytest.approx([-1.0, 1.0, 0.0])
    assert kept.mean_hz() == pytest.approx(1.25)


@pytest.mark.parametrize(
    ("keys", "word"),
    [
        ({"duty": 0.5}, "a sine has no duty"),
        ({"phase_plan": "model", "chirp_hz": 5.0}, "leave chirp_hz"),
        ({"phase_plan": "model", "phase_rad": 1.0}, "leave chirp_hz"),
        ({"plan_parameters": {"f_nat_hz": 200.0}}, "belong to a phase_plan"),
        ({"chirp_hz": -150.0}, "below half the frequency"),
    ],
)
def test_keys_of_the_drive_that_contradict_each_other_are_refused(keys, word):
    with pytest.raises(ValueError, match=word):
        request(**keys)
