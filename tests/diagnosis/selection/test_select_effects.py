"""A torque and a spectral line in one record of an angle: each is judged beside the other."""

from __future__ import annotations

import math

import numpy as np
import pytest

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import MODELS
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, half_cycles

RATE, LINE_HZ, LINE_RAD = 100.0, 3.3, 7e-3


def diagnosed(amplitude, cubic=0.0, dry=0.0, seconds=20.0):
    """The report on a pendulum beside whose angle a line stands; cubic and dry: torques in units of I w^2."""
    time = np.arange(int(seconds * RATE)) / RATE
    w = 2.0 * math.pi * NATURAL_HZ
    angle = half_cycles(
        lambda p, v, sigma, _: -math.sin(p) - cubic * p**3 - 0.008 * v - sigma * dry, amplitude, w * time, 1e-10
    )[0]
    angle += LINE_RAD * np.cos(2.0 * math.pi * LINE_HZ * time + 0.3)
    angle += np.random.default_rng(1).normal(0.0, 3e-4, time.size)
    record = RingDownRecord(angle[None], RATE, "angle")
    return diagnosis_report(diagnose_shots([DiagnosisShot("swing", record, estimate_noise(record))], MODELS["thread"]))


@pytest.mark.parametrize(
    ("amplitude", "torque", "strength", "names"),
    [
        # Neither is sure where the other one stands in the residual: the torque takes half of the signal.
        pytest.param(0.05, {"cubic": 20.0}, 20.0, {"cubic_restoring"}, id="a spring that hides the line"),
        # Beside the line, which is 99.9 % of what is explained, the friction is small.
        pytest.param(0.8, {"dry": 3e-5}, 3e-5 * (2.0 * math.pi * NATURAL_HZ) ** 2, {"coulomb_friction"}, id="friction"),
    ],
)
def test_torque_and_line_are_both_named(amplitude, torque, strength, names):
    report = diagnosed(amplitude, **torque)
    found = {e.id: e for e in report.effects}
    # By 600 held-out samples chi^2/dof scatters by 6 %, which may be a doubt of its own.
    assert report.verdict in ("explained", "partly_explained")
    assert set(found) == {"spectral_line"} | names
    (name,) = names
    assert abs(found[name].strength.value - strength) < 4.0 * found[name].strength.std
    assert found["spectral_line"].strength.value == pytest.approx(LINE_RAD, abs=1e-4)
    assert found["spectral_line"].detail.frequency_hz == pytest.approx(LINE_HZ, abs=1e-3)


def test_a_line_alone_brings_no_torque():
    report = diagnosed(0.8)
    assert (report.verdict, [e.id for e in report.effects]) == ("explained", ["spectral_line"])
