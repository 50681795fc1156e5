"""The weight of a jewel's rotor: what a resonator's file tells of it, and that fits are true with it alone."""

import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from drivers.specimen import Specimen
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.one_angle_error import Fitted, one_angle_error, with_one_angle_error
from platform_daemon.estimation.physics.models import JEWEL, THREAD
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.physics.ring_down import RingDown
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.rotor_fit.shot import RotorContext
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.known_weight import weight_over_pull
from tests.kit.data import CONFIG
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ, SAMPLES = 20_000.0, 10_000
SD = np.array([14e-3, 21e-3, 55e-3])
DRIVE = CoilDrive(field_t=(4e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
DOWN = [0.0, 0.0, -9.81]


def shipped(name, **changes):
    tables = tomllib.loads((CONFIG / "resonators" / f"{name}.toml").read_text())
    return Specimen.model_validate({**tables, **{key: {**tables[key], **table} for key, table in changes.items()}})


def test_the_weight_presses_presses_not_or_pulls_as_the_resonator_is_turned():
    share = weight_over_pull(shipped("jewel_imperfect"))
    rotor = true_rotor(shipped("jewel_imperfect"))
    assert share == pytest.approx(-rotor.parameters[17] / rotor.geometry.pull_n(214.29, rotor.values.distance_m))
    assert 0.005 < share < 0.02
    upside_down = {"rodrigues_rad": [math.pi, 0.0, 0.0]}
    assert weight_over_pull(shipped("jewel_imperfect", pose=upside_down)) == pytest.approx(-share)
    lying = {"rodrigues_rad": [math.pi / 2, 0.0, 0.0]}
    assert weight_over_pull(shipped("jewel_imperfect", pose=lying)) == pytest.approx(0.0, abs=1e-15)


def test_a_thread_and_a_rotor_of_one_angle_have_none():
    assert weight_over_pull(shipped("jewel")) == weight_over_pull(shipped("thread_imperfect")) == 0.0
    assert THREAD.under_weight(0.01) is THREAD
    assert JEWEL.under_weight(0.0) is JEWEL


def test_a_fit_of_a_rigid_rotor_is_true_with_its_weight_and_wrong_without():
    specimen = rigid_specimen("jewel", DOWN, 2.0)
    rotor = true_rotor(specimen, DRIVE)
    noise = np.random.default_rng(1).normal(size=(3, SAMPLES)) * SD[:, None]
    record = RingDownRecord(rotor.dm_dt(SAMPLES, RATE_HZ)[0] + noise, RATE_HZ, "dmdt")
    white = NoiseModel.white(SD, RATE_HZ)

    def off(share):
        ask = FitRequest("jewel", weight_over_pull=share)
        fit = fit_ring_down(record, ask.ring_down_model, SAMPLES / RATE_HZ, noise=white)
        names = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2")
        return fit, {n: (fit.parameters[n].value - getattr(rotor.values, n)) / fit.parameters[n].std for n in names}

    share = weight_over_pull(specimen)
    fit, with_weight = off(share)
    assert max(map(abs, with_weight.values())) < 3.5
    assert off(0.0)[1]["tf_over_i_rad_per_s2"] > 8.0
    assert fit.parameters["weight_over_pull"].value == share
    assert fit.parameters["weight_over_pull"].std is None
    # What is published is the motion that was fitted, under the declared name.
    published = RingDown.from_parameters("jewel", {name: each.value for name, each in fit.parameters.items()})
    again, fitted = (motion.motion(SAMPLES, record.dt_s)[0] for motion in (published, fit.ring_down()))
    assert np.abs(np.abs(again) - np.abs(fitted)).max() < 1e-6


def test_errors_contain_what_a_field_along_the_main_axis_does_to_one_angle():
    """Side modes that it kicks let the contact slip: lambda is off by many errors of the noise, unseen."""
    specimen = rigid_specimen("jewel", DOWN, 2.0)
    turned = rotation_from_rodrigues(np.array([-1e-3, -2.6e-3, -math.pi / 2]))
    drive = replace(DRIVE, field_t=(5e-4, 0.0, 0.0))
    rotor = true_rotor(specimen, drive, rotation=turned)
    samples = int(0.9 * RATE_HZ)
    noise = np.random.default_rng(2).normal(size=(3, samples)) * SD[:, None] / 2
    record = RingDownRecord(rotor.dm_dt(samples, RATE_HZ)[0] + noise, RATE_HZ, "dmdt")
    white, model = NoiseModel.white(SD / 2, RATE_HZ), JEWEL.under_weight(weight_over_pull(specimen))
    known = RotorContext(geometry=rotor.geometry, drive=drive, rotation=turned)
    of_noise = fit_ring_down(record, model, "d30", noise=white)
    fit = with_one_angle_error(of_noise, record, white, model, known)

    def off(of, name):
        return (of.parameters[name].value - getattr(rotor.values, name)) / of.parameters[name].std

    assert abs(off(of_noise, "lambda_per_s")) > 6.0
    assert all(abs(off(fit, name)) < 3.0 for name in ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2"))
    assert "lambda_per_s by" in fit.notes[-1]
    k = fit.covariance_names.index("lambda_per_s")
    assert fit.covariance[k, k] == pytest.approx(fit.parameters["lambda_per_s"].std ** 2)
    # A diagnosis that holds lambda at 0 has no estimate of it.
    values = {name: each.value for name, each in of_noise.parameters.items() if name != "lambda_per_s"}
    fitted = Fitted(model=model, first=0, samples=of_noise.samples, rate_hz=RATE_HZ, sd=white.sd)
    assert set(one_angle_error(fitted, values, known, {"weight_over_pull": values["weight_over_pull"]})) == {
        "f_nat_hz", "m_r_am2", "tf_over_i_rad_per_s2",
    }  # fmt: skip
