"""A thread with a tilted stator: its table, and fits of one angle that are corrected by it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.physics.rigid_rotor.geometry import RotorGeometry
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive, RigidRotor, RotorValues
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.rotor_correction.corrected_fit import corrected_fit
from platform_daemon.estimation.rotor_correction.creation import TableBasis, make_table
from platform_daemon.estimation.rotor_correction.table import CorrectionTable

RATE_HZ, SAMPLES = 20_000.0, 16_000
GEOMETRY = RotorGeometry(bearing="thread", radius_m=1.5e-3, mass_kg=1.1e-4, stator_moment_am2=0.0146, link_m=2e-3)
DRIVE = CoilDrive(field_t=(240e-6, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.0472, rx_start_s=0.0583)
ROTOR = RotorValues(
    f_nat_hz=215.6,
    m_r_am2=0.011,
    lambda_per_s=0.246,
    rotation=np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    distance_m=4.455e-3,
    side_damping_per_s=21.7,
    lean_damping_per_s=21.6,
    stator_tilt_rad=4e-3,
)
CONSTANTS = ("f_nat_hz", "m_r_am2", "lambda_per_s")
SD = np.full(3, 0.01)
NOISE = NoiseModel.white(SD, RATE_HZ)


@pytest.fixture(scope="module")
def table():
    made = make_table(
        TableBasis(
            model=THREAD,
            geometry=GEOMETRY,
            reference=ROTOR,
            drive=DRIVE,
            rate_hz=RATE_HZ,
            samples=SAMPLES,
            held_names=("distance_m", "stator_tilt_rad"),
            held_covariance=np.diag([1e-6, 1e-5]) ** 2,
        )
    )
    return CorrectionTable.from_bytes(made.to_bytes(), THREAD)  # as it is kept


def shot(rotor, seed=1):
    samples, _ = RigidRotor(GEOMETRY, rotor, DRIVE).dm_dt(SAMPLES, RATE_HZ)
    noise = np.random.default_rng(seed).normal(size=samples.shape)
    return RingDownRecord(samples + SD[:, None] * noise, RATE_HZ, "dmdt")


def test_the_constants_are_those_of_the_rotor_where_one_angle_is_wrong(table):
    rotor = ROTOR.with_numbers({"f_nat_hz": 215.63, "lambda_per_s": 0.2475, "m_r_am2": 0.01102, "turn_u_rad": 1e-4})
    record = shot(rotor)
    fit, one = corrected_fit(record, "d30", NOISE, table), fit_ring_down(record, THREAD, "d30", noise=NOISE)
    assert fit.verdict == "good", fit.reason
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=0.05)
    off = {name: abs(fit.parameters[name].value - getattr(rotor, name)) for name in CONSTANTS}
    for name in CONSTANTS:
        assert off[name] < 4.0 * fit.parameters[name].std, name
    assert one.verdict != "good" or any(
        abs(one.parameters[name].value - getattr(rotor, name)) > 4.0 * off[name] for name in CONSTANTS
    )


def test_the_errors_contain_those_of_the_table_and_of_what_is_held(table):
    fit = corrected_fit(shot(ROTOR), "d30", NOISE, table)
    without = corrected_fit(shot(ROTOR), "d30", NOISE, replace(table, error=0.0 * table.error, held=0.0 * table.held))
    for name in CONSTANTS:
        k = table.names.index(name)
        more = table.error[k] ** 2 + table.held[k, k]
        assert fit.parameters[name].std == pytest.approx(math.hypot(without.parameters[name].std, more**0.5)), name
        assert more > 0.0
    k = fit.covariance_names.index("f_nat_hz")
    assert fit.covariance[k, k] == pytest.approx(fit.parameters["f_nat_hz"].std ** 2)


def test_a_shot_outside_of_the_table_is_refused_with_what_lies_outside(table):
    for name, value in (("f_nat_hz", 215.9), ("drive_size", 1.05)):
        fit = corrected_fit(shot(ROTOR.with_numbers({name: value})), "d30", NOISE, table)
        assert fit.verdict == "refused", name
        assert fit.reason.startswith("rotor_correction"), fit.reason
        assert not fit.parameters


def test_another_rotor_is_refused_or_leaves_more_than_noise(table):
    fit = corrected_fit(shot(ROTOR.with_numbers({"stator_tilt_rad": 1.2e-2})), "d30", NOISE, table)
    assert fit.verdict == "refused" or any("residual_not_white" in each for each in fit.warnings)
