"""The list of undeclared effects: what it accepts, and what it leads to."""

import json
import tomllib
from typing import get_args

import numpy as np
import pytest

from drivers.errors import ConfigError
from drivers.validation import validated
from sim_backend.hidden_effects.listing import AnyEffect
from sim_backend.options import SimulatedOptions
from tests.kit.data import ROOT
from tests.kit.simulated_bench import QUIET, Bench, options, specimen

ALL = tomllib.loads("""
[[undeclared]]
id = "coulomb_friction"
strength = 20.0
[[undeclared]]
id = "hertz_friction"
strength = 20.0
[[undeclared]]
id = "stribeck_friction"
strength = 0.3
v_s_rad_per_s = 20.0
[[undeclared]]
id = "friction_fluctuation"
strength = 0.2
tau_s = 0.1
[[undeclared]]
id = "quadratic_drag"
strength = 1e-3
[[undeclared]]
id = "angle_dependent_damping"
strength = 0.5
[[undeclared]]
id = "restoring_anharmonicity"
strength = 0.01
[[undeclared]]
id = "torsion_stiffness"
strength = 0.005
[[undeclared]]
id = "bias_torque"
strength = 2e3
[[undeclared]]
id = "frequency_drift"
strength = 0.1
tau_s = 0.5
[[undeclared]]
id = "frequency_fluctuation"
strength = 0.2
tau_s = 0.1
[[undeclared]]
id = "memory_relaxation"
strength = 1e-3
tau_s = 0.01
[[undeclared]]
id = "memory_bristle"
strength = 10.0
reach_rad = 0.05
[[undeclared]]
id = "memory_amplitude"
strength = 0.01
tau_s = 0.1
[[undeclared]]
id = "breathing_gap"
strength = 0.003
frequency_hz = 800.0
decay_per_s = 20.0
[[undeclared]]
id = "second_mode"
strength = 0.01
frequency_hz = 400.0
decay_per_s = 5.0
order = 2
[[undeclared]]
id = "channel_gain"
strength = -0.02
axis = "x"
frequency_hz = 430.0
width_hz = 200.0
[[undeclared]]
id = "channel_gain"
strength = 0.01
axis = "y"
[[undeclared]]
id = "channel_delay"
strength = 2e-6
axis = "y"
[[undeclared]]
id = "receive_lowpass"
strength = 5e-6
[[undeclared]]
id = "receiver_compression"
strength = 0.1
[[undeclared]]
id = "crosstalk"
strength = 0.01
from = "x"
to = "y"
[[undeclared]]
id = "mains_interference"
strength = 2e-3
frequency_hz = 50
harmonics = [1.0, 0.2, 0.5]
[[undeclared]]
id = "spectral_line"
strength = 1e-3
frequency_hz = 1234.5
[[undeclared]]
id = "side_mode"
strength = 0.05
frequency_hz = 150.0
tau_s = 0.3
axis = "z"
[[undeclared]]
id = "switch_transient"
strength = 0.05
tau_s = 2e-3
axis = "x"
[[undeclared]]
id = "clock_gap"
strength = 3
sample = 4000
""")["undeclared"]


def test_the_configuration_guide_and_this_test_have_every_id():
    known = {get_args(kind.model_fields["id"].annotation)[0] for kind in get_args(AnyEffect)}
    assert {table["id"] for table in ALL} == known
    guide = (ROOT / "docs/reference/configuration.md").read_text()
    assert all(f"| `{name}` |" in guide for name in known)


def read(*tables):
    return validated(SimulatedOptions, options(undeclared=list(tables)), "backends.simulated").hidden_effects


def test_nothing_is_undeclared_by_default():
    assert validated(SimulatedOptions, options(), "backends.simulated").hidden_effects == ()


@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_a_world_of_all_effects_plays_and_its_truth_names_each_with_strength_unit_and_keys(variant):
    bench = Bench(variant, undeclared=ALL)
    for _ in range(2):
        assert np.all(np.isfinite(bench.shot(rx=6000)))
        bench.clock.sleep(1.0)
    truth = bench.truth()
    assert json.loads(json.dumps(truth, allow_nan=False)) == truth
    for asked, told in zip(ALL, truth["undeclared"], strict=True):
        assert told["unit"]
        assert {k: told[k] for k in asked} == asked


def test_the_same_world_plays_the_same_bits_again():
    first, again = (Bench("jewel", undeclared=ALL).shot(rx=3000) for _ in range(2))
    assert np.array_equal(first, again)


def test_an_empty_list_is_the_declared_world():
    assert np.array_equal(Bench("jewel", undeclared=[]).shot(rx=3000), Bench("jewel").shot(rx=3000))


def test_an_unknown_id_is_an_error_that_lists_the_known_ones():
    with pytest.raises(ConfigError, match=r"gremlins.*coulomb_friction.*second_mode.*clock_gap"):
        read({"id": "gremlins", "strength": 1.0})


@pytest.mark.parametrize(
    ("table", "why"),
    [
        ({"strength": 1.0}, "has no key 'id'"),
        ({"id": "quadratic_drag"}, "strength' is missing"),
        ({"id": "quadratic_drag", "strength": -1.0}, "at least 0"),
        ({"id": "coulomb_friction", "strength": float("nan")}, "finite"),
        ({"id": "coulomb_friction", "strength": 1.0, "tau_s": 1.0}, "tau_s' is unknown"),
        ({"id": "stribeck_friction", "strength": 1.0}, "v_s_rad_per_s' is missing"),
        ({"id": "channel_gain", "strength": 0.1}, "give an axis"),
        ({"id": "channel_gain", "strength": 0.1, "frequency_hz": 400.0}, "go together"),
        ({"id": "channel_gain", "strength": 0.1, "axis": "w"}, "'x', 'y' or 'z'"),
        ({"id": "crosstalk", "strength": 0.1, "from": "x", "to": "x"}, "different channels"),
        ({"id": "mains_interference", "strength": 0.1, "frequency_hz": 55.0}, "50 or 60 Hz"),
        ({"id": "clock_gap", "strength": 2.5, "sample": 100}, "a whole number"),
        ({"id": "second_mode", "strength": 0.1, "frequency_hz": 200.0, "decay_per_s": 1.0, "order": 3}, "1 or 2"),
    ],
)
def test_a_wrong_key_is_named(table, why):
    with pytest.raises(ConfigError, match=why):
        read(table)


def test_a_torque_may_stand_there_once_and_a_line_many_times():
    drag = {"id": "quadratic_drag", "strength": 1e-3}
    with pytest.raises(ConfigError, match="quadratic_drag may stand here only once"):
        read(drag, drag)
    assert len(read(*[{"id": "spectral_line", "strength": 1e-3, "frequency_hz": f} for f in (100.0, 200.0)])) == 2


def test_a_pole_on_top_of_a_declared_one_is_refused():
    with pytest.raises(ConfigError, match="differ by at least"):
        Bench("thread", receive__chain="non_ideal", undeclared=[{"id": "receive_lowpass", "strength": 7.95775e-6}])


def test_stribecks_law_without_any_dry_friction_is_refused_when_the_specimen_is_mounted():
    stribeck = {"id": "stribeck_friction", "strength": 0.3, "v_s_rad_per_s": 20.0}
    with pytest.raises(ConfigError, match="no dry friction"):
        Bench("thread", undeclared=[stribeck])
    Bench("jewel", undeclared=[stribeck])
    Bench("thread", undeclared=[stribeck, {"id": "coulomb_friction", "strength": 1.0}])


def with_effects(name, *tables):
    rotor = specimen(name)
    return rotor.model_copy(update={"rotor": rotor.rotor.model_copy(update={"undeclared": tables})})


def test_a_resonator_brings_its_effects_and_takes_them_along():
    gain, dust = {"id": "channel_gain", "strength": -0.03, "axis": "y"}, {"id": "coulomb_friction", "strength": 20.0}
    bench, plain = Bench(None, **QUIET, undeclared=[gain]), Bench("thread", **QUIET, undeclared=[gain])
    bench.backend.mount(with_effects("thread", dust))
    told = Bench("thread", **QUIET, undeclared=[gain, dust])
    assert np.array_equal(bench.shot(rx=2000), told.shot(rx=2000))
    assert not np.array_equal(told.shot(rx=2000), plain.shot(rx=2000))
    assert [effect["id"] for effect in bench.truth()["undeclared"]] == ["channel_gain", "coulomb_friction"]
    bench.backend.mount(specimen("thread"))
    plain.backend.world.hold_still()
    assert np.array_equal(bench.shot(rx=2000), plain.shot(rx=2000))
    assert [effect["id"] for effect in bench.truth()["undeclared"]] == ["channel_gain"]


@pytest.mark.parametrize(
    ("tables", "why"),
    [
        (({"id": "gremlins", "strength": 1.0},), "resonator 'paper thread specimen', rotor.*gremlins"),
        (({"id": "coulomb_friction", "strength": 1.0},) * 2, "only once"),
        (({"id": "friction_fluctuation", "strength": 0.3, "tau_s": 0.1},), "no dry friction that could fluctuate"),
    ],
)
def test_a_wrong_effect_of_a_resonator_is_refused_when_it_is_mounted(tables, why):
    with pytest.raises(ConfigError, match=why):
        Bench(None).backend.mount(with_effects("thread", *tables))


def test_a_second_mode_that_runs_away_is_refused_when_the_specimen_is_mounted():
    mode = {"id": "second_mode", "strength": 0.2, "frequency_hz": 80.0, "decay_per_s": 1.0, "order": 1}
    with pytest.raises(ConfigError, match=r"faster than 86\.28 Hz"):
        Bench("thread", undeclared=[mode])
    for order in (1, 2):
        bench = Bench("jewel", **QUIET, undeclared=[{**mode, "frequency_hz": 90.0, "order": order}])
        assert np.all(np.isfinite(bench.shot(rx=6000)))


def test_a_rotor_under_a_bias_torque_is_at_rest_before_the_first_shot_and_returns_there():
    bias = {"id": "bias_torque", "strength": 5e3}
    bench = Bench("thread", **QUIET, undeclared=[bias])
    bench.shot(field_t=0.0, rx=1000)
    rest = bench.truth()["phi_rad"]
    assert rest == pytest.approx(np.arcsin(5e3 / (2 * np.pi * 215.69) ** 2), rel=1e-9)
    bench.shot(rx=1000)
    bench.clock.sleep(150.0)
    bench.shot(field_t=0.0, rx=1000)
    assert bench.truth()["phi_rad"] == pytest.approx(rest, rel=1e-12)


def test_the_hidden_state_goes_on_between_shots():
    mode = {"id": "second_mode", "strength": 0.01, "frequency_hz": 212.0, "decay_per_s": 0.05, "order": 1}
    bench, other = (Bench("thread", **QUIET, undeclared=[mode]) for _ in range(2))
    bench.shot(rx=610)
    other.shot(rx=610 + 61035)
    other.switch.to_transmit()
    bench.clock.sleep(other.clock.monotonic_s() - bench.clock.monotonic_s())
    for each in (bench, other):
        each.shot(rx=610)
    assert bench.truth()["phi_rad"] == pytest.approx(other.truth()["phi_rad"], rel=1e-8)


def test_frequency_drifts_anew_in_every_shot_from_its_stated_value():
    bench = Bench("thread", **QUIET, undeclared=[{"id": "frequency_drift", "strength": 0.5}])
    for _ in range(2):
        bench.shot(rx=600)
        assert bench.truth()["f_nat_hz"] == 215.69
