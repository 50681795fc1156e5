"""Several kicks in one swing of a pendulum that scipy has made."""

import numpy as np
from scipy.integrate import solve_ivp

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.record import RingDownRecord

RATE_HZ, OMEGA = 100.0, 2.0 * np.pi * 0.6
KICKS = [(8.137, -0.031), (18.524, 0.024), (23.005, -0.022)]  # s, rad/s: 1 % of the first speed


def kicked_swing(drag):
    """Angle (samples,) rad of 40 s; drag: of its square, 1/rad."""

    def motion(t, y):
        return y[1], -(OMEGA**2) * np.sin(y[0]) - 0.03 * y[1] - drag * y[1] * abs(y[1])

    times, parts, state, begin = np.arange(4000) / RATE_HZ, [], np.array([0.6, 0.0]), 0.0
    for end, change in [*KICKS, (40.0, 0.0)]:
        inside = times[(times >= begin) & (times < end)]
        found = solve_ivp(motion, (begin, end), state, t_eval=[*inside, end], method="DOP853", rtol=1e-11, atol=1e-12)
        parts.append(found.y[0][:-1])
        state, begin = found.y[:, -1] + [0.0, change], end
    return np.concatenate(parts) + np.random.default_rng(1).normal(0.0, 2e-3, times.size)


def report_of(angle):
    record = RingDownRecord(samples=angle[None], sampling_rate_hz=RATE_HZ, quantity="angle")
    return diagnosis_report(diagnose_shots([DiagnosisShot("swing", record, estimate_noise(record))], THREAD))


def test_each_of_three_kicks_is_told_with_its_size_and_instant():
    report = report_of(kicked_swing(0.0))
    assert report.verdict == "explained"
    assert {e.id for e in report.effects} == {"kick"}
    told = sorted((e.detail.sample / RATE_HZ, e.strength.value, e.strength.std) for e in report.effects)
    assert len(told) == 3
    for (when_s, size, std), (at_s, true) in zip(told, KICKS, strict=True):
        assert abs(when_s - at_s) < 0.1
        assert abs(size - true) < 3.5 * std


def test_beside_a_loss_they_are_told_too():
    report = report_of(kicked_swing(0.03))
    assert sorted(e.id for e in report.effects) == ["kick", "kick", "kick", "quadratic_drag"]
    (drag,) = (e.strength for e in report.effects if e.id == "quadratic_drag")
    assert abs(drag.value - 0.03) < 3.5 * drag.std
