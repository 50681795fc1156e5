"""phi -> -phi with a half turn about e_u gives the same signal: what a fit says where its convention hangs on noise."""

import math
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import THREAD, model_named
from platform_daemon.estimation.physics.ring_down import RingDown
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE
from platform_daemon.estimation.physics.trajectory.direct import Trajectory
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, random_truth, with_noise

NOISE = NoiseModel.white(NOISE_SD, RATE_HZ)


def on_the_border(rng, off_rad=0.0):
    """A random orientation with e_v perpendicular to x, but for so much; Rodrigues vector."""
    in_plane = Rotation.from_rotvec([rng.uniform(0, 2 * math.pi), 0, 0]) * Rotation.from_rotvec([0, 0, -off_rad])
    return tuple((in_plane * Rotation.from_rotvec([0, rng.uniform(0, 2 * math.pi), 0])).as_rotvec())


def fitted(truth, rng, seconds=0.1, variant="thread"):
    record = RingDownRecord(with_noise(dmdt(truth, seconds), rng), RATE_HZ, "dmdt")
    result = fit_ring_down(record, variant, seconds, noise=NOISE)
    assert result.verdict == "good", result.reason
    return result


def twin_warning(result):
    """(e_v . x, its standard deviation) of the warning; None without."""
    for warning in result.warnings:
        if warning.startswith("twin_undecided"):
            return tuple(map(float, re.findall(r"= (\S+) \+- (\S+):", warning)[0]))
    return None


def e_v_x(result):
    return Rotation.from_rotvec([result.parameters[f"rodrigues_{a}"].value for a in "xyz"]).as_matrix()[0, 1]


def test_where_noise_decides_between_twins_the_result_says_so_with_the_right_error():
    rng = np.random.default_rng(1)
    pulls = []
    for _ in range(80):
        truth = random_truth(rng, "thread", deg_range=(15, 60)).with_(rodrigues=on_the_border(rng))
        result = fitted(truth, rng)
        if twin_warning(result) is None:  # beyond 3 sigma by chance
            continue
        side, std = twin_warning(result)
        assert side == pytest.approx(e_v_x(result), rel=0.06)
        pulls.append(side / std)
    assert len(pulls) > 76
    assert 0.8 < np.sqrt(np.mean(np.square(pulls))) < 1.2


@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_where_the_data_decide_there_is_no_such_warning(variant):
    rng = np.random.default_rng(2)
    for k in range(40):
        truth = random_truth(rng, variant, deg_range=(25, 60))
        truth = truth if k % 2 else truth.with_(rodrigues=on_the_border(rng, off_rad=0.03))
        if abs(Rotation.from_rotvec(truth.rodrigues).as_matrix()[0, 1]) > 0.029:
            assert twin_warning(fitted(truth, rng, variant=variant)) is None


def test_a_bias_torque_changes_sign_with_the_twin():
    rng, found = np.random.default_rng(3), []
    model = model_named("thread+bias_torque")
    w = 2 * math.pi * 215.0
    for _ in range(16):
        vector = on_the_border(rng)
        values = {"f_nat_hz": 215.0, "lambda_per_s": 0.25, "phi_max_rad": 0.5, "psi_start_rad": 1.0}
        known = RingDown.from_parameters(model, values | {"bias_rad_per_s2": 0.05 * w**2}).dynamics
        basis = Trajectory(model, known, 0.2).basis(0, round(0.2 * RATE_HZ), 1 / RATE_HZ, DIPOLE)
        signal = 0.012 * known.w * Rotation.from_rotvec(vector).as_matrix()[:, 1::-1] @ basis[:2]
        p = fit_ring_down(RingDownRecord(with_noise(signal, rng), RATE_HZ, "dmdt"), model, 0.2, noise=NOISE).parameters
        turned = Rotation.from_rotvec([p[f"rodrigues_{a}"].value for a in "xyz"])
        twin = (turned.inv() * Rotation.from_rotvec(vector)).magnitude() > 1
        bias, psi = p["bias_rad_per_s2"], p["psi_start_rad"]
        found.append(twin)
        assert abs((-1 if twin else 1) * bias.value - 0.05 * w**2) < 5 * bias.std
        assert abs(math.remainder(psi.value - 1.0 - (math.pi if twin else 0), 2 * math.pi)) < 5 * psi.std
    assert {True, False} == set(found)


def test_a_diagnosis_takes_all_shots_of_a_resonator_on_one_side():
    rng = np.random.default_rng(4)
    truth = Truth(rodrigues=on_the_border(rng))
    records = [RingDownRecord(with_noise(dmdt(truth, 0.3), rng), RATE_HZ, "dmdt") for _ in range(8)]
    shots = [DiagnosisShot(f"shot {k}", r, NOISE, np.eye(3), "thread") for k, r in enumerate(records)]
    with shot_pool() as pool:
        started, _ = initial_fits(shots, THREAD, pool)
    assert len(started) == 8
    first = started[0].state.observation.rotation
    assert all(np.abs(s.state.observation.rotation - first).max() < 0.05 for s in started)
    assert len({np.sign(s.state.dynamics.amplitude) for s in started}) == 1
