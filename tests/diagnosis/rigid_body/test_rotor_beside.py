"""The search for a rotor beside that for torques."""

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.rigid_body.plane_test import PlaneTest, ShotInPlane
from platform_daemon.diagnosis.rotor_search import RotorBeside
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import JEWEL
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.rotor_fit.shot import RotorContext
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ, SAMPLES, TILT_RAD = 12000.0, 2400, 0.03
SD = np.array([14e-3, 21e-3, 55e-3])
DRIVE = CoilDrive(field_t=(4.9e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
IN_ITS_PLANE, LEAVES_IT = (
    PlaneTest(shots=(ShotInPlane(ratio=r, sd=0.01, noise=0.01, signal=1.0, swing_rad=0.5),)) for r in (1.0, 2.0)
)


@pytest.fixture(scope="module")
def prepared():
    rotor = true_rotor(rigid_specimen("jewel", [0.0, 0.0, -9.81], 22.0, defects={"stator_tilt_rad": TILT_RAD}), DRIVE)
    noise = np.random.default_rng(4).normal(size=(3, SAMPLES)) * SD[:, None]
    record = RingDownRecord(rotor.dm_dt(SAMPLES, RATE_HZ)[0] + noise, RATE_HZ, "dmdt")
    known = RotorContext(geometry=rotor.geometry, drive=DRIVE, rotation=rotor.values.rotation)
    return initial_fits(
        [DiagnosisShot("a.h5 frame 0", record, NoiseModel.white(SD, RATE_HZ), rotor=known)], JEWEL, None
    )[0]


@pytest.fixture(scope="module")
def base(prepared, pool):
    return fit_jointly(prepared, Hypothesis(JEWEL), pool)


@pytest.fixture(scope="module")
def pool():
    with ThreadPoolExecutor(2) as made:
        yield made


def searching() -> bool:
    """A thread of this process is for a rotor."""
    return any(thread.name.startswith("rotor") for thread in threading.enumerate())


@pytest.mark.long
def test_a_rotor_is_sought_beside_torques(base, pool):
    with RotorBeside(IN_ITS_PLANE, pool) as beside:
        assert beside.untried(base) is IN_ITS_PLANE
        beside.begin(base)
        assert searching()
        found = beside.of(base)
        assert beside.of(base) is found
    assert {found.effect.id, *(a.effect.id for a in found.alike)} & {"stator_tilt", "jewel_tilt"}


def test_a_search_that_is_of_no_use_ends_at_once_and_leaves_the_pool(base, pool):
    with RotorBeside(IN_ITS_PLANE, pool) as beside:
        beside.begin(base)
        assert searching()
    assert not searching()
    assert list(pool.map(abs, [-1, 2])) == [1, 2]


def test_none_is_sought_beside_torques_where_it_was_sought_before(base, pool):
    with RotorBeside(LEAVES_IT, pool) as beside:
        assert beside.untried(base) is None
        beside.begin(base)
        assert not searching()
    with RotorBeside(None, pool) as beside:
        assert beside.untried(base) is None
