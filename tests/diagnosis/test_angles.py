"""Angle records that scipy made, whole: what beside the torques, and in how few samples."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from platform_daemon.diagnosis.diagnose import DiagnosisError, diagnose_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import MODELS
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, RATE, bristle, kicked, swing


def diagnosed(angle, noise, seed=1):
    read = angle + np.random.default_rng(seed).normal(0.0, noise, angle.size)
    record = RingDownRecord(read[None], RATE, "angle")
    found = diagnose_shots([DiagnosisShot("swing", record, estimate_noise(record))], MODELS["thread"])
    return diagnosis_report(found)


@pytest.mark.parametrize("mode_hz", [pytest.param(3.1, marks=pytest.mark.long), 9.2])
def test_a_second_mode_is_named_though_it_is_most_of_the_residual(mode_hz):
    angle = swing(0.8, 12.0)
    time = np.arange(angle.size) / RATE
    beside = angle + 4e-3 * np.exp(-time / 2.0) * np.cos(2.0 * np.pi * mode_hz * time)
    report = diagnosed(beside, 5e-4)
    (named,) = report.effects
    assert (report.verdict, named.id) == ("explained", "side_mode")
    assert named.detail.frequency_hz == pytest.approx(mode_hz, abs=0.02)


def test_dry_friction_is_named_in_few_samples():
    angle = swing(0.8, 12.0, dry=0.004)[:: round(RATE / 40.0)]
    read = angle + np.random.default_rng(2).normal(0.0, 2e-4, angle.size)
    record = RingDownRecord(read[None], 40.0, "angle")
    shot = DiagnosisShot("swing", record, estimate_noise(record))
    assert shot.noise.sd[0] == pytest.approx(2e-4, rel=0.4)
    report = diagnosis_report(diagnose_shots([shot], MODELS["thread"]))
    assert [e.id for e in report.effects] == ["coulomb_friction"]


@pytest.mark.parametrize("dry", [0.0, pytest.param(0.002, marks=pytest.mark.long)])
def test_a_kick_is_named_with_its_instant_and_its_size(dry):
    report = diagnosed(kicked(0.8, 25.0, at_period=8.3, change=2e-3, dry=dry), 3e-4)
    names = {e.id: e for e in report.effects}
    assert set(names) == {"kick"} | ({"coulomb_friction"} if dry else set())
    found = names["kick"]
    assert found.strength.value == pytest.approx(2e-3 * 2.0 * np.pi * NATURAL_HZ, rel=0.1)
    assert found.detail.sample / RATE == pytest.approx(8.3 / NATURAL_HZ, abs=0.03 / NATURAL_HZ)


def test_a_kick_that_changes_the_whole_swing_is_told_exactly():
    """A fifth of the velocity: the frequency of the wide swing changes with it, and no linear answer follows that."""
    report = diagnosed(kicked(1.4, 40.0, at_period=9.27, change=0.25), 2e-2)
    (found,) = report.effects
    assert (report.verdict, found.id) == ("explained", "kick")
    assert found.strength.value == pytest.approx(0.25 * 2.0 * np.pi * NATURAL_HZ, abs=3.5 * found.strength.std)
    assert found.strength.std < 0.02 * found.strength.value
    assert found.detail.sample / RATE == pytest.approx(9.27 / NATURAL_HZ, abs=0.01 / NATURAL_HZ)


def test_a_clipped_swing_is_followed_from_where_it_is_whole():
    angle = np.clip(swing(1.2, 40.0, viscous=0.01), -1.0, 9.0)
    report = diagnosed(angle, 0.0)
    (defect,) = report.integrity
    assert (report.verdict, defect.id) == ("nothing_missing", "saturation")
    assert "pile up at its bottom; the swing is followed from sample" in defect.where
    after = report.parameters_after["lambda_per_s"]
    assert after.value == pytest.approx(0.01 * 2.0 * np.pi * NATURAL_HZ, abs=4.0 * after.std)


@pytest.mark.parametrize("cut", [slice(None), slice(0, 1500)])
def test_a_swing_that_is_clipped_to_its_end_is_refused(cut):
    angle = np.clip(swing(1.2, 40.0, viscous=0.001)[cut], -0.9, 9.0)
    record = RingDownRecord(angle[None], RATE, "angle")
    with pytest.raises(DiagnosisError, match="pile up at its bottom"):
        diagnose_shots([DiagnosisShot("swing", record, estimate_noise(record))], MODELS["thread"])


def test_a_line_is_found_beside_a_swing_whose_harmonics_sweep_over_it():
    """From the fourth one on they cover all frequencies of a swing that begins at 110 degrees."""
    angle = swing(1.9, 24.0, viscous=0.012, dry=0.004)
    line = 3e-3 * np.cos(2.0 * np.pi * 31.97 * np.arange(angle.size) / RATE)
    report = diagnosed(angle + line, 1e-3)
    named = {e.id: e for e in report.effects}
    assert (report.verdict, set(named)) == ("explained", {"coulomb_friction", "spectral_line"})
    assert named["spectral_line"].strength.value == pytest.approx(3e-3, rel=0.1)
    assert 0.85 < report.held_out.chi2_per_dof_after < 1.2


def test_friction_that_falls_with_the_speed_to_a_floor_is_told_with_its_floor():
    """Not with a kick or a loss that feeds the motion, which mend what a friction without a floor is wrong by."""
    report = diagnosed(swing(0.75, 50.0, viscous=0.0015, dry=0.0022, more_at_rest=0.0088, speed=0.09), 2.5e-3)
    named = {e.id: e.strength.value / (2.0 * np.pi * NATURAL_HZ) ** 2 for e in report.effects}
    assert (report.verdict, set(named)) == ("explained", {"stribeck_friction", "coulomb_friction"})
    assert named["coulomb_friction"] == pytest.approx(0.0022, rel=0.2)
    assert named["stribeck_friction"] == pytest.approx(0.0088, rel=0.2)


def test_a_filtered_angle_is_judged_by_the_noise_that_the_filter_left():
    angle = swing(0.8, 24.0, dry=0.002)
    read = angle + np.random.default_rng(1).normal(0.0, 3e-4, angle.size)
    filtered = sosfiltfilt(butter(4, 20.0, fs=RATE, output="sos"), read)[200:-200]  # without what the ends do to it
    record = RingDownRecord(filtered[None], RATE, "angle")
    report = diagnosis_report(
        diagnose_shots([DiagnosisShot("swing", record, estimate_noise(record))], MODELS["thread"])
    )
    assert (report.verdict, [e.id for e in report.effects]) == ("explained", ["coulomb_friction"])
    assert 0.1 < report.held_out.chi2_per_dof_after < 2.0
    friction = report.effects[0].strength
    assert abs(friction.value - 0.002 * (2.0 * np.pi * NATURAL_HZ) ** 2) < 4.0 * friction.std


def test_a_contact_that_is_a_spring_before_it_slides_is_one_effect():
    report = diagnosed(bristle(0.8, 40.0, 0.003, 0.01), 3e-4)
    assert (report.verdict, [e.id for e in report.effects]) == ("explained", ["dahl_friction"])
    (named,) = report.effects
    assert named.strength.value == pytest.approx(0.003 * (2.0 * np.pi * NATURAL_HZ) ** 2, rel=0.03)
    assert named.detail.hidden_scales()["dahl_displacement_rad"] == pytest.approx(0.01, rel=0.2)


@pytest.mark.parametrize(("name", "power"), [("quadratic_nonlinearity", 2), ("cubic_nonlinearity", 3)])
@pytest.mark.parametrize("bent", [0.02, pytest.param(0.1, marks=pytest.mark.long)])
def test_a_scale_that_is_not_straight_is_no_torque(name, power, bent):
    angle = swing(0.8, 25.0)
    report = diagnosed(angle + bent * angle**power, 5e-4)
    assert (report.verdict, [e.id for e in report.effects]) == ("explained", [name])
    (named,) = report.effects
    assert abs(named.strength.value - bent) < 4.0 * named.strength.std
