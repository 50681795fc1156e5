"""One angle's fit of a shot of a rigid rotor, as the diagnosis makes it before it seeks the rotor."""

from __future__ import annotations

import numpy as np

from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive, RigidRotor
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.rotor_fit.shot import RotorContext

SD = np.array([14e-3, 21e-3, 55e-3])  # A m^2/s, of white noise


def one_angle_of(
    rotor: RigidRotor, model: RingDownModel, drive: CoilDrive | None, *, samples: int, rate_hz: float, late: int
) -> JointFit:
    """drive: that is known of the shot; late: samples at its beginning that are not valid."""
    noise = np.random.default_rng(3).normal(size=(3, samples)) * SD[:, None]
    record = RingDownRecord(rotor.dm_dt(samples, rate_hz)[0] + noise, rate_hz, "dmdt", valid_from=late)
    known = RotorContext(geometry=rotor.geometry, drive=drive, rotation=None)
    shot = DiagnosisShot("a.h5 frame 0", record, NoiseModel.white(SD, rate_hz), rotor=known)
    prepared, _ = initial_fits([shot], model, None)
    return fit_jointly(prepared, Hypothesis(model), InlineExecutor())
