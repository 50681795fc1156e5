"""A jewel whose resonator nobody declares: its rotor's weight is in the errors, and in those of nobody else."""

import numpy as np
import pytest

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.findings.undeclared_weight import weight_of_drawing, with_weight_in_friction
from platform_daemon.diagnosis.regression.parameters import Mean
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import JEWEL
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.rotor_fit.shot import RotorContext
from platform_daemon.features.fit.known_weight import weight_over_pull
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ, SAMPLES = 20_000.0, 20_000
SD = np.array([14e-3, 21e-3, 55e-3])
DRIVE = CoilDrive(field_t=(4e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
LOSSES = ("lambda_per_s", "tf_over_i_rad_per_s2")


@pytest.fixture(scope="module")
def specimen():
    return rigid_specimen("jewel", [0.0, 0.0, -9.81], 2.0)


def diagnosed(specimen, geometry):
    rotor = true_rotor(specimen, DRIVE)
    noise = np.random.default_rng(3).normal(size=(3, SAMPLES)) * SD[:, None]
    record = RingDownRecord(rotor.dm_dt(SAMPLES, RATE_HZ)[0] + noise, RATE_HZ, "dmdt")
    known = RotorContext(geometry=geometry, drive=None, rotation=None)
    shot = DiagnosisShot("shot", record, NoiseModel.white(SD, RATE_HZ), rotor=known)
    report = diagnosis_report(diagnose_shots([shot], JEWEL))
    off = {n: (report.parameters_after[n].value - getattr(rotor.values, n)) for n in LOSSES}
    return report, {n: abs(off[n]) / report.parameters_after[n].std for n in LOSSES}


def test_losses_of_an_undeclared_jewel_are_true_within_errors_that_contain_the_weight(specimen):
    drawing = true_rotor(specimen).geometry
    undeclared, off = diagnosed(specimen, drawing.with_tolerances())
    assert undeclared.verdict == "nothing_missing"
    assert max(off.values()) < 2.0
    share = weight_over_pull(specimen)
    friction = undeclared.parameters_after["tf_over_i_rad_per_s2"]
    assert friction.std == pytest.approx(share * friction.value, rel=0.5)
    assert any(note.startswith("no resonator is declared") for note in undeclared.notes)
    declared, far = diagnosed(specimen, drawing)
    assert far["tf_over_i_rad_per_s2"] > 8.0  # whoever declares a resonator tells its weight, here none
    assert not any("no resonator is declared" in note for note in declared.notes)


def test_only_an_undeclared_jewel_with_a_frequency_and_a_moment_has_such_a_weight(specimen):
    drawing = true_rotor(specimen).geometry
    found = {name: Mean(value=value, std=1e-4 * value, scatter=None) for name, value in _CONSTANTS.items()}
    share = weight_of_drawing(drawing.with_tolerances(), found)
    assert share == pytest.approx(weight_over_pull(specimen), rel=0.02)
    assert weight_of_drawing(drawing, found) == 0.0
    assert weight_of_drawing(drawing.with_tolerances(), {"f_nat_hz": found["f_nat_hz"]}) == 0.0
    thread = true_rotor(rigid_specimen("thread")).geometry.with_tolerances()
    assert weight_of_drawing(thread, found) == 0.0
    wider, (note,) = with_weight_in_friction(found, drawing.with_tolerances())
    friction = wider["tf_over_i_rad_per_s2"]
    assert friction.std == pytest.approx(share * friction.value, rel=0.01)
    assert note.startswith("no resonator is declared")
    assert with_weight_in_friction(found, drawing) == (found, ())


_CONSTANTS = {"f_nat_hz": 213.6, "m_r_am2": 11.9e-3, "tf_over_i_rad_per_s2": 1170.0}
