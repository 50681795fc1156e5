"""`diagnose` and `fit` on files that are no ring-down of one angle: one line, what was seen, where, and a remedy."""

import math
from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.kit.command_line import assert_one_line_error, here
from tests.kit.specimen_files import pendulum, swing

RATE, COUNT = 400.0, math.pi / 4096


def counted(angle, noise=0.5, seed=1):
    """As an encoder reads it."""
    moved = angle + noise * COUNT * np.random.default_rng(seed).standard_normal(angle.size)
    return COUNT * np.round(moved / COUNT)


def driven(at, damping, push, seconds=20.0, settled=0.0):
    """(time, angle) of a pendulum of 2 Hz under a steady torque at this frequency, from rest."""
    t, w = np.arange(int(seconds * RATE)) / RATE, 4.0 * math.pi
    found = solve_ivp(
        lambda x, y: (
            y[1],
            -w * w * math.sin(y[0]) - 2.0 * damping * y[1] + push * w * w * math.cos(2 * math.pi * at * x),
        ),
        (0.0, settled + seconds), (0.0, 0.0), "DOP853", t_eval=settled + t, rtol=1e-9, atol=1e-11,
    )  # fmt: skip
    return t, counted(found.y[0])


def time_back(t):
    t[2000:] -= 1.0


def time_still(t):
    t[2000:2100] = t[2000]


def rates(t):
    t[2500:] += 3.0 * np.arange(t.size - 2500) / RATE


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (time_back, ("/time: runs back from 4.9975 s to 4 s at sample 2000", "a file of its own")),
        (time_still, ("/time: repeats: sample 2001", "98 more times", "a time of its own")),
        (rates, ("/time: mixes sampling rates: 400 Hz, but 100 Hz from sample 2500 at 6.25 s", "of their own")),
    ],
)
def test_a_time_column_that_is_none_is_bad_input(tmp_path, change, words):
    t, angle = swing(noise=0.0)
    change(t)
    path = pendulum(tmp_path, t, counted(angle))
    for command in ("diagnose", "fit", "slide"):
        options = ("--window", "4") if command == "slide" else ()
        assert_one_line_error(here(command, path, *options), 2, *words)


@pytest.mark.long
def test_a_hole_in_an_even_column_is_no_bad_input(tmp_path):
    t, angle = swing()
    keep = np.ones(t.size, dtype=bool)
    keep[800:830] = False
    done = here("diagnose", pendulum(tmp_path, t[keep], angle[keep]), "--variant", "thread_small_angle")
    assert done.returncode == 0, done.stderr
    assert "integrity: clock_gap" in done.stdout


def test_degrees_under_the_name_of_radians_are_told_so(tmp_path):
    t, angle = swing()
    path = pendulum(tmp_path, t, np.degrees(angle))
    for command in ("diagnose", "fit"):
        assert_one_line_error(here(command, path), 2, "/signal: goes from -2", "beyond pi", 'units of /signal to "deg"')
    done = here("fit", pendulum(tmp_path, t, np.degrees(angle), units="deg"), "--variant", "thread_small_angle")
    assert done.returncode == 0, done.stderr


def test_two_channels_are_no_angle(tmp_path):
    t, angle = swing()
    path = pendulum(tmp_path, t, np.stack([angle, angle]))
    for command in ("diagnose", "fit"):
        assert_one_line_error(here(command, path), 2, "/signal: has shape (2, 4800): 2 channels", "file of its own")


def constant():
    return swing()[0], np.full(4800, 0.02)


def rest():
    return swing()[0], counted(np.full(4800, 0.02))


def one_period():
    t, angle = swing(noise=0.0)
    return t[:200], counted(angle[:200])


def with_nan():
    t, angle = swing()
    angle[3000:3010] = np.nan
    return t, angle


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (constant, ("no_signal: every sample is 0.02 rad: nothing moves", "from its release on")),
        (rest, ("no_signal: the angle stays between 0.0", "nothing in it swings", "from its release on")),
        (one_period, ("too_short: 2 passages through the middle in 0.5 s", "at least 5 periods")),
        (with_nan, ("not_finite: 10 samples, the first is 3000", "longest stretch of finite samples")),
    ],
)
def test_a_series_without_a_swing_is_refused_with_3(tmp_path, make, words):
    path = pendulum(tmp_path, *make())
    assert_one_line_error(here("diagnose", path), 3, "no shot can be used", *words)
    done = here("fit", path)
    assert done.returncode == 3
    (line,) = done.stderr.strip().splitlines()
    for word in ("every frame was refused: frame 0: ", *words):
        assert word in line


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (partial(driven, 1.7, 0.3, 0.06, settled=60.0), ("does not die away", "is it driven?", "without a drive")),
        (partial(driven, 1.95, 0.3, 0.05, settled=60.0), ("does not die away", "is it driven?", "without a drive")),
        (partial(driven, 2.2, 0.01, 0.05), ("the swing grows from", "is it driven", "without a drive")),
    ],
)
def test_a_driven_swing_is_not_diagnosed(tmp_path, make, words):
    assert_one_line_error(here("diagnose", pendulum(tmp_path, *make())), 3, "no_decay: ", *words)
