"""A recording whose drive is not the one that was played, and a fit that ended above its minimum."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from platform_daemon.diagnosis.findings.rotor_findings import assumed_notes
from platform_daemon.diagnosis.rigid_body import search
from platform_daemon.diagnosis.rigid_body.plane_test import plane_test
from platform_daemon.diagnosis.rotor_search import rotor_of
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.rotor_fit.shot import RotorContext
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ, SAMPLES = 12000.0, 6000
SD = np.array([14e-3, 21e-3, 55e-3])
DRIVE = CoilDrive(field_t=(2.2e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
TILT_RAD = 0.012


@pytest.mark.long
@pytest.mark.parametrize(
    ("said", "doubted"),
    [(DRIVE, False), (replace(DRIVE, field_t=(4.4e-4, 0.0, 0.0), frequency_hz=205.0, phase_rad=1.57), True)],
)
def test_a_recorded_drive_that_was_not_played_is_left_out_and_the_tilt_is_right(said, doubted):
    rotor = true_rotor(rigid_specimen("thread", [0.0, 0.0, -9.81], 22.0, defects={"stator_tilt_rad": TILT_RAD}), DRIVE)
    noise = np.random.default_rng(4).normal(size=(3, SAMPLES)) * SD[:, None]
    record = RingDownRecord(rotor.dm_dt(SAMPLES, RATE_HZ)[0] + noise, RATE_HZ, "dmdt")
    known = RotorContext(geometry=rotor.geometry, drive=said, rotation=rotor.values.rotation)
    shot = DiagnosisShot("a.h5 frame 0", record, NoiseModel.white(SD, RATE_HZ), rotor=known)
    prepared, _ = initial_fits([shot], THREAD, None)
    with ThreadPoolExecutor(2) as pool:
        declared, found = rotor_of(prepared, THREAD, plane_test(prepared), pool)
    value, std = found.strength, found.std
    assert abs(value - TILT_RAD) < 4 * std < 0.1 * TILT_RAD
    notes = assumed_notes([p.shot for p in declared.prepared])
    assert [("recorded drive" in note) for note in notes] == [True] * doubted


@dataclass(frozen=True)
class _Fit:
    defect: str
    total_chi2: float
    chi2_per_dof: float = 1.0
    shots: tuple = ()
    stages: tuple = ()


@pytest.mark.parametrize(("late_chi2", "again"), [(99_000.0, 2), (99_995.0, 0), (100_005.0, 0)])
def test_errors_begin_once_more_from_one_that_shows_that_the_best_was_no_minimum(late_chi2, again, monkeypatch):
    fit = _Fit
    tried = []
    monkeypatch.setattr(
        search, "fits_instead", lambda leader, rivals, _pool: tried.extend((leader, r) for r in rivals) or rivals
    )
    found = search.Contestant(fit("stator_tilt_rad", 1e5), SimpleNamespace())
    late = [fit("lateral_displacement_m", 100_002.0), fit("bearing_tilt_rad", late_chi2, stages=(1,))]
    shot = object()
    more = search.once_more_from_late(shot, found, late, SimpleNamespace())
    assert more == [defect for _, defect in tried] == ["stator_tilt_rad", "lateral_displacement_m"][:again]
    assert all(
        (leader.defect, leader.shots, leader.stages) == ("bearing_tilt_rad", (shot,), (1,)) for leader, _ in tried
    )


@pytest.mark.long
def test_the_shot_that_swings_most_is_fitted_before_the_others():
    """In the first one the motion along the axis drowns in the noise; its values in common led the others astray."""
    rotor = true_rotor(rigid_specimen("thread", [0.0, 0.0, -9.81], 22.0, defects={"stator_tilt_rad": TILT_RAD}), DRIVE)
    rng, shots = np.random.default_rng(5), []
    for k, share in enumerate((0.15, 0.2, 1.0)):
        drive = replace(DRIVE, field_t=(share * DRIVE.field_t[0], 0.0, 0.0))
        played = replace(rotor, drive=drive)
        record = RingDownRecord(
            played.dm_dt(SAMPLES, RATE_HZ)[0] + rng.normal(size=(3, SAMPLES)) * SD[:, None], RATE_HZ, "dmdt"
        )
        known = RotorContext(geometry=rotor.geometry, drive=drive, rotation=rotor.values.rotation)
        shots.append(DiagnosisShot(f"a.h5 frame {k}", record, NoiseModel.white(SD, RATE_HZ), rotor=known))
    prepared, _ = initial_fits(shots, THREAD, None)
    plane = plane_test(prepared)
    assert plane.leaves
    assert len(plane.share) == 1
    with ThreadPoolExecutor(2) as pool:
        declared, found = rotor_of(prepared, THREAD, plane, pool)
    assert [p.shot.name[-1] for p in declared.prepared] == ["2", "0", "1"]
    assert found.fit.chi2_per_dof == pytest.approx(1.0, abs=0.05)
    assert found.held_out.is_good
    of_tilt = found.strength if found.effect.id == "stator_tilt" else found.alike[0].strength
    assert of_tilt == pytest.approx(TILT_RAD, rel=0.1)
