"""Stamps that leave an even clock: followed where the samples do, and left alone where they are rounded."""

import h5py
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import platform_daemon as pd_
from platform_daemon.core.recordings.angle_series import read_angles
from platform_daemon.core.recordings.array_recording import signal_of
from platform_daemon.core.recordings.even_clock import deviation_s, evened, rounding_s
from tests.kit.command_line import run

STEP_S, N = 0.01, 3000
NUMBER = np.arange(N)
RNG = np.random.default_rng(5)


def swing(time_s, noise_rad=0.0):
    """30 degrees at 1.2 Hz that decay by 0.02 /s."""
    angle = np.radians(30.0) * np.exp(-0.02 * time_s) * np.cos(2.0 * np.pi * 1.2 * time_s)
    return angle + noise_rad * np.random.default_rng(1).standard_normal(time_s.size)


def clock(relative):
    """Stamps whose steps differ by these shares of one."""
    stamps = np.cumsum(STEP_S * (1.0 + relative))
    return stamps - stamps[0]


CLOCKS = {
    "drifts by 0.005 %": clock(5e-5 * NUMBER / N),
    "drifts by 0.2 %": clock(2e-3 * NUMBER / N),
    "drifts by 1 %": clock(1e-2 * NUMBER / N),
    "scatters by 10 %": clock(0.1 * RNG.standard_normal(N).clip(-2, 2)),
    "breathes by 10 %": clock(0.1 * np.sin(2.0 * np.pi * NUMBER / N)),
    "another rate by 15 %": clock(np.where(NUMBER < N // 2, 0.0, 0.15)),
}


@pytest.mark.parametrize("time_s", CLOCKS.values(), ids=CLOCKS)
def test_samples_follow_stamps_that_leave_an_even_clock(time_s):
    found = pd_.from_arrays(time_s, angle_rad=swing(time_s))
    even = found.time_s()
    assert even[-1] == pytest.approx(time_s[-1], rel=1e-12)
    np.testing.assert_allclose(found.signal()[0], swing(even), atol=3e-7)
    assert "interpolated at even times" in found.notes[0]


def test_the_remark_says_how_far_in_ms_and_in_steps():
    time_s = CLOCKS["drifts by 1 %"]
    most_s = np.abs(deviation_s(time_s)).max()
    said = (
        f"the times leave an even clock by up to {1e3 * most_s:.3g} ms, {most_s / np.diff(time_s).mean():.2g} of a step"
    )
    assert said in pd_.from_arrays(time_s, angle_rad=swing(time_s)).notes[0]


def pendulum(time_s):
    """The same of a pendulum, by its equation of motion, with noise."""

    def slope(_, state):
        return state[1], -((2.0 * np.pi * 1.2) ** 2) * np.sin(state[0]) - 0.04 * state[1]

    ends, start = (0.0, time_s[-1]), [np.radians(30.0), 0.0]
    found = solve_ivp(slope, ends, start, t_eval=time_s, rtol=1e-10, atol=1e-12, method="DOP853")
    return found.y[0] + 1e-3 * np.random.default_rng(7).standard_normal(time_s.size)


@pytest.mark.parametrize("name", ["drifts by 0.005 %", "drifts by 1 %", "scatters by 10 %", "another rate by 15 %"])
def test_a_fit_of_them_is_right_within_its_errors(name):
    time_s = CLOCKS[name]
    fit = pd_.fit(pd_.from_arrays(time_s, angle_rad=pendulum(time_s)), model="thread")
    for parameter, true in (("f_nat_hz", 1.2), ("lambda_per_s", 0.02), ("phi_max_rad", np.radians(30.0))):
        assert abs(fit[parameter].value - true) < 3.0 * fit[parameter].std, parameter


@pytest.mark.parametrize(
    "time_s",
    [
        NUMBER / 97.3,
        np.round(NUMBER / 97.3, 3),
        np.round(NUMBER / 97.3, 4),
        np.floor(NUMBER / 97.3 * 1e3) / 1e3,
        np.round(NUMBER / 97.3, 6),
        np.round(NUMBER / 97.3, 6) + 1.7e9,
        np.round(1e3 * NUMBER / 97.3) * 1e-3 / 60.0 * 60.0,
        np.array([float(f"{t:.4E}") for t in NUMBER / 97.3]),
        np.array([float(f"{t / 60.0:.5f}") for t in NUMBER / 97.3]) * 60.0,
        (NUMBER / 97.3).astype(np.float32).astype(np.float64),
    ],
    ids=["even", "1 ms", "0.1 ms", "cut to ms", "1 us", "1 us since 1970", "ms", "five digits", "minutes", "32 bits"],
)
def test_rounded_stamps_of_an_even_clock_are_not_corrected(time_s):
    """And their rate is that of all of them: the rounding of the last one alone is 50 errors of a frequency."""
    angle = swing(NUMBER / 97.3, 1e-4)
    found = pd_.from_arrays(time_s, angle_rad=angle)
    assert np.array_equal(found.signal()[0], angle)
    assert found.notes == ()
    assert found.sampling_rate_hz() == pytest.approx(97.3, rel=3e-6)


def test_the_last_digit_of_stamps_is_found():
    assert rounding_s(np.round(NUMBER / 97.3, 3)) == pytest.approx(1e-3)
    assert rounding_s(np.round(NUMBER / 97.3, 6)) == pytest.approx(1e-6)
    assert rounding_s(NUMBER / 97.3) < 1e-12


def test_stamps_that_scatter_beside_even_samples_are_not_followed():
    """As of a computer that was busy when it wrote them."""
    time_s = NUMBER * STEP_S + 6e-4 * RNG.uniform(-1.0, 1.0, N)
    angle = swing(NUMBER * STEP_S, 1e-4)
    found = pd_.from_arrays(time_s, angle_rad=angle)
    assert np.array_equal(found.signal()[0], angle)
    assert "smoother without that, and were taken as even" in found.notes[0]


@pytest.mark.parametrize("share", [1e-2, 2e-4])
def test_rounded_stamps_of_a_drifting_clock_are_followed(share):
    """Also where the drift is smaller than the rounding, but no even clock can have been rounded to these stamps."""
    true_s = clock(share * NUMBER / N)
    found = pd_.from_arrays(np.round(true_s, 3), angle_rad=pendulum(true_s))
    assert "interpolated at even times" in found.notes[0]
    fit = pd_.fit(found, model="thread")
    assert abs(fit["lambda_per_s"].value - 0.02) < 3.0 * fit["lambda_per_s"].std


def test_samples_too_coarse_to_be_interpolated_are_refused(tmp_path):
    time_s = CLOCKS["drifts by 1 %"]
    with pytest.raises(pd_.RecordingError, match="4 samples a period, too few to interpolate") as found:
        signal_of(time_s, np.cos(2.0 * np.pi * 25.0 * time_s), "angle", where="a.csv")
    assert "even rate" in found.value.remedy
    assert evened(NUMBER * STEP_S, np.cos(0.5 * np.pi * NUMBER), "a.csv").remark == ""  # an even clock needs none


def test_channels_of_volts_are_interpolated_together():
    time_s = CLOCKS["drifts by 0.2 %"]
    volts = np.stack([[swing(time_s), 2.0 * swing(time_s)]])
    found = pd_.from_arrays(time_s, voltage=volts)
    np.testing.assert_allclose(found.signal()[1], 2.0 * swing(found.time_s()), atol=1e-6)
    assert any("interpolated at even times" in note for note in found.notes)


def test_a_file_of_angles_is_told_of_too(tmp_path):
    time_s = CLOCKS["drifts by 1 %"]
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["time"], file["signal"] = time_s, swing(time_s)[None]
    found = read_angles(tmp_path / "a.h5")
    np.testing.assert_allclose(found.angle_rad[0], swing(NUMBER / found.sampling_rate_hz), atol=1e-6)
    assert found.clock == ()
    assert "interpolated at even times" in found.done[0]


def test_commands_say_so(tmp_path):
    time_s = CLOCKS["drifts by 1 %"]
    np.savetxt(tmp_path / "a.txt", np.column_stack([time_s, swing(time_s)]), header="t_s phi_rad")
    done = run("info", tmp_path / "a.txt")
    assert "interpolated at" in " ".join(done.stdout.split())


@pytest.mark.parametrize("turned", [0.0, np.pi])
def test_wrapped_angles_are_unwrapped_and_that_is_told(turned):
    angle = swing(NUMBER * STEP_S) + turned
    wrapped = np.mod(angle, 2.0 * np.pi) if turned == 0.0 else np.mod(angle + np.pi, 2.0 * np.pi) - np.pi
    found = pd_.from_arrays(NUMBER * STEP_S, angle_rad=wrapped)
    moved = found.signal()[0] - angle
    np.testing.assert_allclose(moved, np.full(N, moved[0]), atol=1e-12)
    assert "whole turn" in found.notes[0]
