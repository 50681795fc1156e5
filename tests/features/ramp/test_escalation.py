"""Ramps on curves of the z residual that are known: where they end, how far they go, how often they stop falsely."""

import numpy as np
import pytest

from platform_daemon.features.ramp.escalation import Escalation, RampPlan
from platform_daemon.features.ramp.onset_test import OnsetTest
from platform_daemon.features.ramp.threshold import ThresholdPosterior
from platform_daemon.features.ramp.z_residual import ZResidual

SHAPES = {
    "rises evenly": lambda b, at: 0.4 * np.exp((b - at) / 40e-6),
    "jumps": lambda b, at: 0.4 / (1.0 + np.exp(-(b - at) / 8e-6)) * 2.0,
    "is flat": lambda b, at: 0.4 + 3.5e3 * (b - at),
}


def ramped(curve, seed=0, start=150e-6, most=500e-6, scatter=0.02, noise=0.005):
    rng = np.random.default_rng(seed)
    state = Escalation(RampPlan(start, 10e-6, most, 0.25, 0.002, 6))
    while (field := state.next_field()) is not None:
        size = max(curve(field), 0.0) * (1.0 + scatter * rng.standard_normal()) + noise * rng.standard_normal()
        state.see(field, [ZResidual(size if size > 2.0 * noise else 0.0, noise, ())])
    return state


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("at", [223e-6, pytest.param(317e-6, marks=pytest.mark.long)])
def test_a_ramp_finds_the_threshold_and_goes_no_step_beyond(shape, at):
    for seed in range(3):
        state = ramped(lambda b: SHAPES[shape](b, at), seed)
        value, low, high = state.threshold_t()
        assert value == pytest.approx(at, abs=15e-6)
        assert low - 2e-6 <= at <= high + 2e-6
        assert max(state.seen) < at + 10e-6


def test_fields_never_rise_by_more_than_a_step_and_doubt_costs_shots():
    state = ramped(lambda b: SHAPES["rises evenly"](b, 300e-6))
    fields = list(state.seen)
    assert max(np.diff(fields)) < 10.001e-6
    assert sum(map(len, state.seen.values())) < 2 * len(fields) + 12


def test_where_nothing_shows_the_ramp_goes_to_its_end():
    state = ramped(lambda b: 0.0)
    assert max(state.seen) == pytest.approx(500e-6)
    assert state.threshold_t() is None
    assert state.ended_by() == "requested_limit"
    assert state.why_ended() == "no side modes up to 500 uT, the highest field that was requested"


def test_a_ramp_that_begins_above_the_threshold_says_so_and_knows_none():
    state = ramped(lambda b: SHAPES["rises evenly"](b, 120e-6))
    assert list(state.seen) == [150e-6]
    assert state.threshold_t() is None
    assert state.ended_by() == "first_field"
    assert "start lower" in state.why_ended()


DRAWS = 600


@pytest.mark.long
def test_just_below_the_level_side_modes_are_called_visible_as_rarely_as_stated():
    rng, stops = np.random.default_rng(5), 0
    for _ in range(DRAWS):
        test = OnsetTest(0.02)
        for k in range(10):
            for size in 0.4 + 0.01 * rng.standard_normal(4):
                test.see(1e-6 * k, size, 0.01)
                if test.visible(1e-6 * k):
                    stops += 1
                    break
            else:
                continue
            break
    assert stops / DRAWS < 0.02 + 3.0 * np.sqrt(0.02 / DRAWS)


def test_what_is_plainly_there_is_called_visible_soon():
    test = OnsetTest(0.002)
    for size in (0.47, 0.46, 0.48):
        test.see(1e-4, size, 0.015)
    assert test.visible(1e-4)


def test_a_posterior_needs_a_field():
    with pytest.raises(ValueError, match="field"):
        ThresholdPosterior.of([], [], [])


def test_the_next_field_has_a_reason_and_no_step_up_a_chance_that_is_too_high():
    state, told = Escalation(RampPlan(150e-6, 10e-6, 500e-6, 0.25, 0.002, 6)), []
    rng = np.random.default_rng(0)
    while (field := state.next_field()) is not None:
        if state.seen:
            assert state.posterior is not None
            here, why = state.decided()
            assert here == field
            told.append(why)
            assert (field in state.seen) == (why in ("doubt", "more_shots"))
            if field not in state.seen:
                assert state.posterior.chance_below(field) < 0.25
                assert (field - max(state.seen) > 9.99e-6) == (why == "step")
        size = SHAPES["rises evenly"](field, 300e-6) * (1.0 + 0.02 * rng.standard_normal())
        state.see(field, [ZResidual(size, 0.005, ())])
    assert told[0] == "step"
    assert {"step", "smaller_step", "more_shots"} <= set(told)
    assert state.decided() is None


def test_where_the_bound_is_nearer_than_a_step_the_ramp_says_that_it_goes_to_the_bound():
    state = Escalation(RampPlan(150e-6, 10e-6, 155e-6, 0.25, 0.002, 6))
    state.see(150e-6, [ZResidual(0.0, 0.005, ())])
    assert state.decided() == (155e-6, "bound")


def test_the_curve_of_the_posterior_is_short_and_its_median_is_the_threshold():
    state = ramped(lambda b: SHAPES["rises evenly"](b, 300e-6))
    fields, chances = state.posterior.curve()
    assert fields.size == chances.size == 80
    assert (fields[0], fields[-1]) == (state.posterior.fields_t[0], state.posterior.fields_t[-1])
    assert np.all(np.diff(chances) >= 0.0)
    assert np.interp(0.5, chances, fields) == pytest.approx(state.posterior.quantile(0.5), rel=0.01)


def test_while_no_shot_can_be_used_the_ramp_stays_at_its_first_field():
    state = Escalation(RampPlan(150e-6, 10e-6, 500e-6, 0.25, 0.002, 6))
    state.see(150e-6, [])
    assert state.next_field() == 150e-6
    state.see(150e-6, [ZResidual(0.0, 0.005, ())])
    assert state.next_field() == pytest.approx(160e-6)
