"""Models as data: the catalogue, what they know of their parameters, and every way to observe them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import JEWEL, MODELS, THREAD, Parameter, RingDownModel, model_named
from platform_daemon.estimation.physics.torques.frequency_drift import FREQUENCY_DRIFT
from platform_daemon.estimation.physics.torques.magnetic_restoring import MAGNETIC_RESTORING
from platform_daemon.estimation.physics.torques.viscous_damping import VISCOUS_DAMPING
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, with_noise

WHITE = NoiseModel.white(NOISE_SD, RATE_HZ)
P = np.array([[1.1e-3, 8e-6, -5e-6], [-6e-6, 1.0e-3, 9e-6], [4e-6, -7e-6, 8.8e-4], [5e-4, 5e-4, 0.0]])
SHOT = Truth(f_nat_hz=213.05, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.9, psi_start_rad=3.8)


def record_of(truth, seconds=0.3, seed=0):
    return RingDownRecord(with_noise(dmdt(truth, seconds), np.random.default_rng(seed)), RATE_HZ, "dmdt")


def simulated(model, values, amplitude=0.6, seconds=0.5, seed=0):
    """A noisy shot of a model that the independent generator does not know."""
    dynamics = MotionParameters(w=2 * math.pi * 215.0, theta=1.0, amplitude=amplitude, values=values)
    n = round(seconds * RATE_HZ)
    local = 0.012 * dynamics.w * Trajectory(model, dynamics, seconds).basis(0, n, 1 / RATE_HZ, 0)[:2]
    signal = np.stack([0.8 * local[0], 0.6 * local[0], local[1]])
    return RingDownRecord(with_noise(signal, np.random.default_rng(seed)), RATE_HZ, "dmdt")


@pytest.mark.parametrize("name", sorted(MODELS))
def test_every_declared_model_recovers_its_own_shots(name):
    model = model_named(name)
    truth = {"lambda_per_s": 0.25, "tf_over_i_rad_per_s2": 1200.0, "coulomb_rad_per_s2": 1200.0}
    values = tuple(truth[c.name] for c in model.coefficients)
    result = fit_ring_down(simulated(model, values), name, 1.0, noise=WHITE)
    assert result.verdict == "good", result.reason
    assert result.chi2_per_dof == pytest.approx(1.0, abs=0.03)
    assert abs(result.parameters["f_nat_hz"].value - 215.0) < 5 * result.parameters["f_nat_hz"].std
    for c in model.coefficients:
        estimate = result.parameters[c.name]
        assert abs(estimate.value - truth[c.name]) < 5 * estimate.std


@pytest.mark.parametrize("drift", [0.0, 2e-3])
def test_a_model_whose_torque_depends_on_time_is_fitted_too(drift):
    model = THREAD.with_terms("drifting", FREQUENCY_DRIFT)
    assert model.time_dependent
    result = fit_ring_down(simulated(model, (0.25, drift)), model, 1.0, noise=WHITE)
    assert result.verdict == "good", result.reason
    for name, value in (("f_nat_hz", 215.0), ("frequency_drift_per_s", drift), ("lambda_per_s", 0.25)):
        assert abs(result.parameters[name].value - value) < 5 * result.parameters[name].std, name


def test_channels_with_free_gains_and_with_known_ones_tell_the_same_motion():
    signal = with_noise(dmdt(SHOT, 0.4), np.random.default_rng(1))
    tied = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), JEWEL, 0.4)
    free = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), replace(JEWEL, observation="free_gains"), 0.4)
    assert "m_r_am2" in tied.parameters
    assert "m_r_am2" not in free.parameters
    for name in ("f_nat_hz", "phi_max_rad", "tf_over_i_rad_per_s2"):
        assert abs(free.parameters[name].value - tied.parameters[name].value) < 4 * free.parameters[name].std
    assert math.cos(free.parameters["psi_start_rad"].value - tied.parameters["psi_start_rad"].value) > 0.9


@pytest.mark.parametrize("channels", [3, 4])
def test_volts_of_known_sensitivity_give_the_moment(channels):
    p = P[:channels]
    sd = np.abs(p).max(axis=1) * 0.02
    volts = with_noise(-p @ dmdt(SHOT, 0.4), np.random.default_rng(2), sd)
    result = fit_ring_down(RingDownRecord(volts, RATE_HZ, "voltage", sensitivity=p), "jewel", 0.4)
    assert result.verdict == "good", result.reason
    for name in ("f_nat_hz", "m_r_am2", "phi_max_rad", "psi_start_rad", "rodrigues_z"):
        assert abs(result.parameters[name].value - SHOT.value(name)) < 4 * result.parameters[name].std, name


@pytest.mark.parametrize("sensitivity", [np.ones((3, 3)), np.eye(2), np.full((3, 3), np.nan)])
def test_a_sensitivity_that_cannot_be_inverted_makes_no_record(sensitivity):
    with pytest.raises(ValueError, match="sensitivity"):
        RingDownRecord(np.zeros((3, 100)), RATE_HZ, "voltage", sensitivity=sensitivity)


def test_a_prior_sharpens_its_parameter_and_is_reported():
    record = record_of(SHOT, 0.25)
    knowing = replace(JEWEL, known=(Parameter("lambda_per_s", "1/s", prior=(0.2465, 5e-4)),))
    plain = fit_ring_down(record, JEWEL, "n50")
    helped = fit_ring_down(record, knowing, "n50")
    name = "lambda_per_s"
    together = (plain.parameters[name].std ** -2 + 5e-4**-2) ** -0.5
    assert helped.parameters[name].std == pytest.approx(together, rel=0.02)
    pulled = together**2 * (plain.parameters[name].value / plain.parameters[name].std ** 2 + 0.2465 / 5e-4**2)
    assert helped.parameters[name].value == pytest.approx(pulled, abs=0.05 * together)
    assert "prior: lambda_per_s = 0.2465 +- 0.0005" in helped.notes


def test_a_model_may_hold_a_parameter_by_itself():
    holding = replace(JEWEL, known=(Parameter("lambda_per_s", "1/s", fixed=0.2465),))
    result = fit_ring_down(record_of(SHOT), holding, "n50")
    assert result.parameters["lambda_per_s"].value == 0.2465
    assert result.parameters["lambda_per_s"].std is None


def test_an_estimate_outside_its_bounds_is_refused_and_not_clamped():
    bounded = replace(THREAD, known=(Parameter("f_nat_hz", "Hz", lower=220.0, upper=230.0),))
    result = fit_ring_down(record_of(Truth()), bounded, "n50")
    assert result.verdict == "refused"
    assert result.reason.startswith("out_of_range: f_nat_hz")
    with pytest.raises(ValueError, match="outside"):
        fit_ring_down(record_of(Truth()), bounded, "n50", fixed={"f_nat_hz": 215.0})


def test_a_model_that_makes_no_sense_cannot_be_made():
    with pytest.raises(ValueError, match="twice"):
        RingDownModel("twice", (MAGNETIC_RESTORING, VISCOUS_DAMPING, VISCOUS_DAMPING))
    with pytest.raises(ValueError, match="no parameter"):
        replace(THREAD, known=(Parameter("tf_over_i_rad_per_s2", "rad/s^2"),))
    with pytest.raises(ValueError, match="unknown variant"):
        model_named("torsion")


def test_every_public_parameter_has_a_unit():
    for model in MODELS.values():
        assert all(p.unit for p in model.parameters.values())
        assert {c.name for c in model.coefficients} < set(model.parameters)
