"""Peaks, I2t and energy against closed forms and against an integrator."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from drivers.errors import SequenceRejected
from platform_daemon.core.settings import load_sequence
from sequences.compiler import compile_shot
from sequences.request import SequenceRequest
from tests.kit.transmit_side import side

THREAD = load_sequence("thread").model_dump()


def plan(limits=None, **keys):
    return compile_shot(SequenceRequest(**{**THREAD, **keys}), side(**(limits or {})))


@pytest.mark.parametrize("f", [212.0, 2000.0])
def test_a_steady_sine_has_the_figures_of_its_amplitude(f):
    shot = plan(f_tx_hz=f, tx_periods=10)
    (coil,), tx_s = shot.figures.coils, shot.timeline.tx_samples / shot.timeline.clock.rate_hz
    assert coil.peak_a == pytest.approx(0.215, rel=1e-4)
    assert coil.peak_v == pytest.approx(shot.drives[0].amplifier_v, rel=1e-3)
    assert coil.i2t_a2s == pytest.approx(0.5 * 0.215**2 * tx_s, rel=1e-3)
    assert coil.energy_j == pytest.approx(coil.heat_j, rel=1e-3)
    assert shot.figures.peak_field_t == pytest.approx(215e-6, rel=1e-4)


def test_a_sine_that_begins_at_its_top_goes_beyond_its_amplitude_as_an_integrator_says():
    shot = plan(f_tx_hz=212.0, phase_rad=1.3)
    burst, c = shot.timeline.bursts[0], shot.drives[0].channel

    def slope(t, i):
        volts = c.amplifier_gain * burst.amplitude_v * np.sin(2 * np.pi * burst.frequency_hz * t + burst.phase_rad)
        return (volts - c.resistance_ohm * i) / c.inductance_h

    tx_s = shot.timeline.tx_samples / shot.timeline.clock.rate_hz
    found = solve_ivp(slope, (0, tx_s), [0.0], "DOP853", rtol=1e-10, atol=1e-12, dense_output=True)
    t = np.linspace(0, tx_s, 20_000)
    (coil,) = shot.figures.coils
    assert coil.peak_a == pytest.approx(np.max(np.abs(found.sol(t)[0])), rel=1e-4)
    until_then = quad(lambda x: found.sol(x)[0] ** 2, 0, tx_s, limit=400)[0]
    after = found.sol(tx_s)[0] ** 2 * c.inductance_h / c.resistance_ohm / 2
    assert coil.i2t_a2s == pytest.approx(until_then + after, rel=1e-3)


@pytest.mark.parametrize(
    ("limits", "word"),
    [({"max_coil_i2t_a2s": 1e-3}, "I2t of coil x"), ({"max_coil_heat_w": 2e-4}, "the heat of coil x")],
)
def test_i2t_and_heat_have_limits_of_their_own(limits, word):
    assert plan().figures.coils[0].i2t_a2s > 1e-3
    with pytest.raises(SequenceRejected, match=word) as caught:
        plan(limits)
    assert next(iter(limits)) in (caught.value.why or "")


def test_a_field_at_the_very_limit_is_allowed_and_none_beyond():
    plan({"max_field_t": 215e-6})
    with pytest.raises(SequenceRejected, match="field"):
        plan({"max_field_t": 214.9e-6})


def test_a_blank_shot_does_nothing_to_the_coils():
    figures = compile_shot(SequenceRequest(**THREAD), side(), blank=True).figures
    assert figures.coils == ()
    assert figures.peak_field_t == 0.0
