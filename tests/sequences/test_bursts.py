"""What the card plays makes the field that was asked for, through the real loops; by sines and by levels."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import lsim

from drivers.errors import SequenceRejected
from drivers.io_card import CardCapabilities
from platform_daemon.core.settings import load_sequence
from sequences.compiler import ShotPlan, compile_shot
from sequences.lobes import Lobes
from sequences.request import SequenceRequest
from tests.kit.transmit_side import side

THREAD = load_sequence("thread").model_dump()
SINES, LEVELS = {"retunes": True, "holds_levels": True}, {"holds_levels": True, "step_samples": 16}


def shot(card: dict[str, object], limits: dict[str, float] | None = None, **keys: object) -> ShotPlan:
    platform = side(**(limits or {}))
    platform = replace(platform, card=replace(platform.card, **card))
    request = SequenceRequest(**{**THREAD, **keys})
    if request.phase_plan == "none":
        return compile_shot(request, platform)
    zeros = np.concatenate(([0.0], np.cumsum(0.5 / np.linspace(230.0, 200.0, 18))))
    return compile_shot(request, platform, planned=Lobes(zeros, -1))


def field_t(plan: ShotPlan, per_sample: int = 16) -> tuple[np.ndarray, np.ndarray]:
    """Times and field (3, n), the loops as scipy's linear systems under the voltage that is played."""
    rate = plan.timeline.clock.rate_hz * per_sample
    samples = plan.timeline.tx_samples
    t = np.arange(samples * per_sample) / rate
    total = np.zeros((3, t.size))
    for d in plan.drives:
        c = d.channel
        volts = c.amplifier_gain * plan.timeline.output_volts(c.output, 0, samples, per_sample)
        loop = ([1.0], [c.inductance_h, c.resistance_ohm])
        current = lsim(loop, volts, t)[1]
        total += np.outer(c.field_per_ampere_t, current)
    return t, total


@pytest.mark.parametrize("keys", [{"chirp_hz": -20.0}, {"phase_plan": "model"}])
@pytest.mark.parametrize(("card", "within"), [(SINES, 0.03), (LEVELS, 0.25)])
def test_the_field_follows_its_half_periods_whatever_the_card_can(card, within, keys):
    plan = shot(card, axis=(0.6, -0.8, 0.0), **keys)
    t, field = field_t(plan, 2)
    wanted = 215e-6 * np.outer([0.6, -0.8, 0.0], plan.lobes.at(t))
    assert np.max(np.abs(field - wanted)) < within * 215e-6
    # What works on the rotor is the part that goes with the field asked for.
    assert np.sum(field * wanted) / np.sum(wanted**2) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("card", [SINES, LEVELS])
def test_a_rectangle_reaches_its_height_and_changes_sign_with_its_half_periods(card):
    plan = shot(card, waveform="rectangle", duty=1.0)
    t, field = field_t(plan, 2)
    assert plan.figures.peak_field_t == pytest.approx(215e-6, rel=0.02)
    # The fundamental of the field is in phase with the half periods though the loop is late.
    turn = np.exp(-2j * np.pi * plan.frequency_hz * t)
    angle = np.angle(np.sum(field[0] * turn) / np.sum(plan.lobes.at(t) * turn))
    assert abs(np.degrees(angle)) < 6


def test_edges_of_levels_lie_on_the_cards_grid_and_never_overlap():
    for keys in ({"chirp_hz": -20.0}, {"waveform": "rectangle", "duty": 1.0}, {"waveform": "rectangle", "duty": 0.3}):
        bursts = shot(LEVELS, **keys).timeline.bursts
        assert all(b.start_sample % 16 == b.stop_sample % 16 == 0 and b.frequency_hz == 0 for b in bursts)
        assert all(a.stop_sample <= b.start_sample for a, b in pairwise(bursts))


@pytest.mark.parametrize(
    ("keys", "word"),
    [
        ({"chirp_hz": -20.0}, "frequency changes"),
        ({"waveform": "rectangle"}, "a rectangle"),
        ({"phase_plan": "model"}, "frequency changes"),
    ],
)
def test_a_card_that_can_play_one_sine_only_is_told_before_anything_moves(keys, word):
    with pytest.raises(SequenceRejected, match=word) as caught:
        shot({}, **keys)
    assert "one running sine" in (caught.value.why or "")


def test_too_few_levels_per_period_are_refused():
    with pytest.raises(SequenceRejected, match="levels per period"):
        shot(LEVELS, f_tx_hz=900.0, chirp_hz=-5.0)


def test_a_plain_sine_is_one_burst_on_every_card():
    card = CardCapabilities(
        inputs=3,
        outputs=3,
        input_full_scale_v=1.0,
        output_full_scale_v=1.0,
        clock=side().card.clock,
        max_samples=2_000_000,
    )
    assert len(shot({"retunes": card.retunes}, phase_rad=1.0).timeline.bursts) == 1
