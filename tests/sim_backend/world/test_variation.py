import numpy as np
import pytest

from sim_backend.hidden_effects.torques import FrequencyFluctuation, FrictionFluctuation
from sim_backend.options import EffectsOptions
from sim_backend.rotor.rigid_body.acceleration import HERTZ, MU
from sim_backend.rotor.rigid_body.parameters import body_parameters
from sim_backend.rotor.rotor import FLUCTUATION_WAVES, effective
from sim_backend.world.variation import (
    Temperature,
    friction_factor,
    rotor_in_shot,
    with_fluctuations,
    with_scatter,
)
from tests.kit.simulated_bench import Bench, options, specimen


def effects(**changes):
    return EffectsOptions.model_validate(options(**{f"effects__{k}": v for k, v in changes.items()})["effects"])


def test_temperature_moves_f_nat_and_m_r_by_their_coefficients():
    rotor = effective(specimen("jewel"))
    warm = rotor_in_shot(rotor, effects(), 2.0, 1.0)
    assert warm.f_nat_hz - rotor.f_nat_hz == pytest.approx(-0.46)
    assert warm.m_r_am2 / rotor.m_r_am2 == pytest.approx(1 - 0.0022)
    assert warm.inertia_kg_m2 == rotor.inertia_kg_m2
    assert warm.tf_over_i_rad_per_s2 == rotor.tf_over_i_rad_per_s2


def test_friction_varies_with_the_contact_and_not_with_its_coefficient():
    rotor = effective(specimen("jewel_imperfect"))
    rough = rotor_in_shot(rotor, effects(), 0.0, 1.7)
    assert rough.tf_over_i_rad_per_s2 == pytest.approx(1.7 * rotor.tf_over_i_rad_per_s2)
    before, now = body_parameters(rotor), body_parameters(rough)
    assert now[MU] == pytest.approx(before[MU], rel=1e-12)
    assert now[HERTZ] == pytest.approx(1.7 * before[HERTZ], rel=1e-12)


def test_f_nat_scatters_by_the_papers_eight_hundredths_of_a_hertz():
    temperature = Temperature(effects().temperature, np.random.default_rng(5))
    shots = [temperature.deviation_k(15.0 * k) for k in range(20_000)]
    assert np.std(shots) * 0.23 == pytest.approx(0.08, rel=0.08)
    assert np.mean(shots) == pytest.approx(0.0, abs=0.05)


def test_temperature_wanders_with_its_correlation_time():
    temperature = Temperature(effects().temperature, np.random.default_rng(6))
    path = np.array([temperature.deviation_k(t) for t in np.arange(0, 200_000, 10.0)])
    lagged = np.corrcoef(path[:-6], path[6:])[0, 1]
    assert lagged == pytest.approx(np.exp(-1), abs=0.05)
    assert abs(temperature.deviation_k(100.0) - temperature.deviation_k(100.01)) < 0.01


def test_temperature_depends_on_time_and_not_on_who_asks():
    one, two = (Temperature(effects().temperature, np.random.default_rng(7)) for _ in range(2))
    for t in np.random.default_rng(0).uniform(0, 5000, 300):
        two.deviation_k(t)
    assert [one.deviation_k(t) for t in (1.0, 50.0, 4000.0)] == [two.deviation_k(t) for t in (1.0, 50.0, 4000.0)]


def test_without_the_effect_the_temperature_stays_at_its_mean():
    still = Temperature(effects(temperature__enabled=False).temperature, np.random.default_rng(8))
    assert {still.celsius(t) for t in (0.0, 1e3, 1e5)} == {22.0}


def test_friction_scatters_lognormally_with_mean_one():
    rng, only = np.random.default_rng(9), effects(wear__enabled=False)
    factors = np.array([friction_factor(only, rng, 0) for _ in range(20_000)])
    assert factors.mean() == pytest.approx(1.0, abs=0.01)
    assert factors.std() == pytest.approx(0.27, rel=0.03)
    assert np.log(factors).std() == pytest.approx(np.sqrt(np.log1p(0.27**2)), rel=0.02)


def test_friction_fluctuates_with_its_correlation_time_and_unit_variance():
    effect = FrictionFluctuation(id="friction_fluctuation", strength=0.3, tau_s=0.2)
    rng, rotor = np.random.default_rng(10), effective(specimen("jewel"))
    drawn = np.stack([with_fluctuations(rotor, (effect,), rng).friction_waves for _ in range(4000)])
    omega, phase = drawn[:, :, 0], drawn[:, :, 1]
    now, then = (np.sqrt(2 / FLUCTUATION_WAVES) * np.cos(omega * t + phase).sum(axis=1) for t in (0.3, 0.5))
    assert [now.mean(), now.std()] == pytest.approx([0.0, 1.0], abs=0.05)
    assert np.mean(now * then) == pytest.approx(np.exp(-1), abs=0.05)
    assert with_fluctuations(rotor, (), rng) is rotor


def test_friction_and_frequency_fluctuate_by_waves_of_their_own():
    both = (
        FrictionFluctuation(id="friction_fluctuation", strength=0.3, tau_s=0.2),
        FrequencyFluctuation(id="frequency_fluctuation", strength=0.2, tau_s=0.1),
    )
    rotor = with_fluctuations(effective(specimen("jewel")), both, np.random.default_rng(10))
    alone = with_fluctuations(effective(specimen("jewel")), both[:1], np.random.default_rng(10))
    assert np.array_equal(rotor.friction_waves, alone.friction_waves)
    assert alone.frequency_waves is None
    assert np.all(rotor.frequency_waves != rotor.friction_waves)


def test_frequency_damping_and_orientation_scatter_as_the_file_of_the_resonator_says():
    declared = specimen("thread").rotor.model_copy(
        update={
            "f_nat_scatter_hz": 0.1,
            "lambda_scatter": 0.004,
            "orientation_scatter_rad": (1e-4, 2e-4, 14e-4),
        }
    )
    rng, rotor = np.random.default_rng(11), effective(specimen("thread"))
    shots = [with_scatter(rotor, declared, rng) for _ in range(4000)]
    assert np.std([shot.f_nat_hz for shot in shots]) == pytest.approx(0.1, rel=0.05)
    assert np.mean([shot.f_nat_hz for shot in shots]) == pytest.approx(rotor.f_nat_hz, abs=0.006)
    assert np.std([shot.lambda_per_s for shot in shots]) == pytest.approx(0.004 * rotor.lambda_per_s, rel=0.05)
    turns = np.stack([rotor.rotation.T @ shot.rotation for shot in shots])
    about = np.array([turns[:, 2, 1], turns[:, 0, 2], turns[:, 1, 0]])
    assert about.std(axis=1) == pytest.approx([1e-4, 2e-4, 14e-4], rel=0.05)


def test_one_value_of_the_orientations_scatter_holds_for_each_axis():
    declared = specimen("thread").rotor.model_copy(update={"orientation_scatter_rad": 5e-4})
    rng, rotor = np.random.default_rng(12), effective(specimen("thread"))
    turns = np.stack([rotor.rotation.T @ with_scatter(rotor, declared, rng).rotation for _ in range(4000)])
    about = np.array([turns[:, 2, 1], turns[:, 0, 2], turns[:, 1, 0]])
    assert about.std(axis=1) == pytest.approx([5e-4] * 3, rel=0.05)


def test_nothing_is_drawn_for_a_resonator_that_does_not_scatter():
    rng, rotor = np.random.default_rng(13), effective(specimen("thread"))
    assert with_scatter(rotor, specimen("thread").rotor, rng) is rotor
    assert rng.random() == np.random.default_rng(13).random()


def test_friction_creeps_up_with_wear():
    only = effects(friction_scatter__enabled=False)
    assert friction_factor(only, np.random.default_rng(), 0) == 1.0
    assert friction_factor(only, np.random.default_rng(), 100) == pytest.approx(1.05)


def test_shots_of_a_jewel_differ_in_friction_and_every_effect_can_be_switched_off():
    varying = Bench("jewel")
    seen = []
    for _ in range(4):
        varying.shot(rx=100)
        seen.append(varying.truth()["tf_over_i_rad_per_s2"])
    assert len(set(seen)) == 4
    off = {f"effects__{name}__enabled": False for name in ("temperature", "friction_scatter", "wear")}
    steady = Bench("jewel", **off)
    for _ in range(2):
        steady.shot(rx=100)
        truth = steady.truth()
        assert (truth["tf_over_i_rad_per_s2"], truth["f_nat_hz"], truth["m_r_am2"]) == (1324.0, 213.25, 12.028e-3)


def test_wear_counts_the_shots_of_each_specimen():
    bench = Bench("jewel", effects__friction_scatter__enabled=False, effects__temperature__enabled=False)
    for _ in range(3):
        bench.shot(rx=100)
    assert bench.truth()["tf_over_i_rad_per_s2"] == pytest.approx(1324.0 * (1 + 2 * 5e-4))
    bench.backend.mount(specimen("thread"))
    bench.shot(rx=100)
    assert bench.truth()["tf_over_i_rad_per_s2"] == 0.0
    bench.backend.mount(specimen("jewel"))
    bench.shot(rx=100)
    assert bench.truth()["tf_over_i_rad_per_s2"] == pytest.approx(1324.0 * (1 + 3 * 5e-4))


def test_truth_states_the_temperature_that_made_the_frequency():
    bench = Bench("thread")
    for _ in range(3):
        bench.clock.sleep(70.0)
        bench.shot(rx=100)
        truth = bench.truth()
        assert truth["f_nat_hz"] == pytest.approx(215.69 - 0.23 * (truth["temperature_c"] - 22.0), abs=1e-9)
        assert bench.thermometer.temperature_c() == pytest.approx(truth["temperature_c"], abs=0.15)
