"""The paper's excitation on the whole platform, against an integration that shares nothing with it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.settings import load_specimen
from tests.kit.acquisitions import acquire

QUIET = (
    "backends.simulated.effects.temperature.enabled=false",
    "backends.simulated.effects.friction_scatter.enabled=false",
    "backends.simulated.effects.wear.enabled=false",
)
INERTIA = 8 / 15 * math.pi * 7800 * 1.5e-3**5
FIELD_T = {"thread": 215e-6, "jewel": 490e-6}


def deflection_deg(variant: str, field_t: float, frequency_hz: float) -> float:
    """Energy amplitude after ten periods of a zero-phase sine along v, from rest; friction switched at each turn."""
    m = load_specimen(variant)[0].measured
    omega, friction = 2 * math.pi * m.f_nat_hz, m.tf_over_i_rad_per_s2 or 0.0
    drive = m.m_r_am2 / INERTIA * field_t

    def slope(t, y, sign):
        hertz = friction * max(math.cos(y[0]), 0.0) ** (4 / 3)
        push = drive * math.sin(2 * math.pi * frequency_hz * t) * math.cos(y[0])
        return [y[1], -2 * m.lambda_per_s * y[1] - omega**2 * math.sin(y[0]) - sign * hertz + push]

    def turn(t, y, sign):
        return y[1]

    turn.terminal = True
    # From rest the drive must first exceed static friction; until then nothing moves.
    t = math.asin(friction / drive) / (2 * math.pi * frequency_hz) if friction else 0.0
    y, sign, end = [0.0, 0.0], 1.0, 10 / frequency_hz
    while t < end:
        turn.direction = -sign
        found = solve_ivp(slope, (t, end), y, "DOP853", events=turn, args=(sign,), rtol=1e-11, atol=1e-13)
        t, y, sign = found.t[-1], found.y[:, -1], -sign
        y[1] = 0.0 if found.status == 1 else y[1]
    return math.degrees(math.acos(math.cos(y[0]) - y[1] ** 2 / (2 * omega**2)))


@pytest.fixture(scope="module")
def first_shots(tmp_path_factory):
    from platform_daemon.core.settings import load_platform
    from platform_daemon.processes.assembly import start_engine

    folder, found = tmp_path_factory.mktemp("excitation"), {}
    for variant in FIELD_T:
        engine = start_engine(load_platform("simulated", QUIET))
        job = acquire(engine, folder / f"{variant}.h5", resonator=variant, sequence={"rx_s": 0.5}, window=None)
        engine.close()
        assert job.error is None
        found[variant] = folder / f"{variant}.h5"
    return found


def truth(path):
    return next(iter(read_truth(path)[0].values()))


@pytest.mark.parametrize(("variant", "about_deg"), [("thread", 22.7), ("jewel", 55.9)])
def test_the_papers_field_deflects_as_an_independent_integration_says(first_shots, variant, about_deg):
    expected = deflection_deg(variant, FIELD_T[variant], 10 * 125e6 / 2048 / 2879)
    assert expected == pytest.approx(about_deg, abs=0.1)
    assert math.degrees(truth(first_shots[variant])["amplitude_tx_end_rad"]) == pytest.approx(expected, abs=0.05)


def amplitudes(path):
    """Peak of dm/dt along v (x) and u (-y) in the first three periods, A m^2/s."""
    recording = open_recording(path)
    n = round(3 / 212 * recording.sequence.rate_hz)
    dmdt = -np.linalg.inv(recording.calibration.sensitivity) @ recording.rx_volts(0)[:, :n]
    return np.abs(dmdt[0]).max(), np.abs(dmdt[1]).max()


def test_start_amplitudes_of_jewel_and_thread_stand_in_the_ratio_of_the_shipped_parameters(first_shots):
    (thread_v, thread_u), (jewel_v, jewel_u) = (amplitudes(first_shots[v]) for v in ("thread", "jewel"))
    assert 2.2 < jewel_v / thread_v < 2.6
    assert 5.3 < jewel_u / thread_u < 5.9
