"""The picture of a swing that is a hundred times slower than a resonator shows periods and lines, and no empty axes."""

import numpy as np

import platform_daemon as pd_


def test_the_picture_of_a_slow_pendulum_shows_some_periods_and_its_line():
    time_s = np.arange(2000) / 100.0
    angle = 0.3 * np.exp(-0.05 * time_s) * np.cos(2 * np.pi * 0.9 * time_s)
    fit = pd_.fit(pd_.from_arrays(time_s, angle_rad=angle))
    _, zoom, _, spectrum = fit.plot().axes
    measured = zoom.lines[0].get_xdata()
    assert 3 < measured[-1] * 0.9 < 10  # periods
    assert zoom.get_xlabel() == "time / s"
    f_hz, amplitude = spectrum.lines[0].get_data()
    assert abs(f_hz[np.argmax(amplitude)] - 0.9) < 0.1
