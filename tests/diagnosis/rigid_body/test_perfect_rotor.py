"""Rotors without a manufacturing error that one angle does not quite explain, and one whose law is another."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.findings.rotor_findings import has_model_error
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.rigid_body import defects
from platform_daemon.diagnosis.rigid_body.defects import manufacturing_error
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.rotor_fit.shot import RotorContext
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ = 12000.0
SD = np.array([14e-3, 21e-3, 55e-3])
DRIVE = CoilDrive(field_t=(2.2e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
GRAVITY = [0.0, 0.0, -9.81]


def shot_of(rotor, seconds, beside=0.0):
    """A shot of a rotor; beside: what stands in the samples that no rotor has, (3, n) or 0."""
    count = round(seconds * RATE_HZ)
    noise = np.random.default_rng(4).normal(size=(3, count)) * SD[:, None]
    record = RingDownRecord(rotor.dm_dt(count, RATE_HZ)[0] + noise + beside, RATE_HZ, "dmdt")
    known = RotorContext(geometry=rotor.geometry, drive=DRIVE, rotation=rotor.values.rotation)
    return DiagnosisShot("a.h5 frame 0", record, NoiseModel.white(SD, RATE_HZ), rotor=known)


@pytest.mark.long
def test_a_perfect_rotor_whose_axis_leans_is_explained_without_an_effect():
    upright = true_rotor(rigid_specimen("thread", GRAVITY, 5.0), DRIVE)
    lean = rotation_from_rodrigues(np.array([0.004, 0.002, 0.0])) @ upright.values.rotation
    rotor = true_rotor(rigid_specimen("thread", GRAVITY, 5.0), DRIVE, rotation=lean)
    found = diagnose_shots([shot_of(rotor, 1.0)], THREAD)
    assert found.verdict == "nothing_missing"
    assert found.named == ()
    assert any("without a manufacturing error" in note for note in found.notes)
    for name in ("f_nat_hz", "m_r_am2", "lambda_per_s"):
        after = found.parameters_after[name]
        assert abs(after.value - getattr(rotor.values, name)) < 4.0 * after.std, name


@pytest.mark.long
def test_a_rotor_that_follows_another_law_is_no_full_explanation_and_has_wider_errors():
    rotor = true_rotor(rigid_specimen("thread", GRAVITY, 22.0, defects={"stator_tilt_rad": 0.012}), DRIVE)
    time_s = np.arange(6000) / RATE_HZ
    strange = 0.35 * SD[:, None] * np.cos(2.0 * np.pi * 321.0 * time_s)
    with ThreadPoolExecutor(2) as pool:
        found = []
        for beside in (0.0, strange):
            prepared, _ = initial_fits([shot_of(rotor, 0.5, beside)], THREAD, None)
            found.append(manufacturing_error(fit_jointly(prepared, Hypothesis(THREAD), pool), pool))
    plain, doubtful = found
    assert not has_model_error(plain)
    assert has_model_error(doubtful)
    assert doubtful.std > 1.5 * plain.std


@pytest.mark.long
def test_a_rotor_that_does_not_predict_the_ends_of_shots_does_not_explain_them(monkeypatch):
    tilted = true_rotor(rigid_specimen("thread", GRAVITY, 22.0, defects={"stator_tilt_rad": 0.02}), DRIVE)
    shot = shot_of(tilted, 0.6)
    right = diagnose_shots([shot], THREAD)
    ends = defects.held_out_ends

    def four_times(*args):
        found = ends(*args)
        return replace(found, chi2=tuple(4.0 * dof for dof in found.dof))

    monkeypatch.setattr(defects, "held_out_ends", four_times)
    wrong = diagnose_shots([shot], THREAD)
    assert (right.verdict, wrong.verdict) == ("explained", "partly_explained")
    assert wrong.rotor.strength == pytest.approx(right.rotor.strength)
    assert wrong.rotor.std == pytest.approx(2.0 * right.rotor.std)
    assert wrong.parameters_after["lambda_per_s"].std > 1.5 * right.parameters_after["lambda_per_s"].std
    (note,) = [n for n in wrong.notes if "chi2/dof 4 only" in n]
    assert note not in right.notes
