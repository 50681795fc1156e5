"""What is drawn of a frame."""

from platform_daemon.features.fit import measurement
from platform_daemon.features.fit.measurement import open_voltages
from platform_daemon.features.fit.plot_data import ring_down_plot_data
from tests.kit.data import DATA


def test_a_picture_is_calibrated_once(monkeypatch):
    opened = open_voltages(DATA / "example_thread.mmr.h5")
    calls = []
    real = measurement.calibrated_signal
    monkeypatch.setattr(measurement, "calibrated_signal", lambda *args: calls.append(1) or real(*args))
    shown = ring_down_plot_data(opened, 0, "undamped", 0.1)
    assert len(calls) == 1
    assert (shown.model is None) == (shown.fit.verdict == "refused")
