"""A recording's fits as they are reported and drawn."""

from platform_daemon.analysis import fit
from platform_daemon.store.reader import open_recording
from tests.kit.data import DATA


def test_a_picture_is_calibrated_once(monkeypatch):
    calls = []
    real = fit.ring_down
    monkeypatch.setattr(fit, "ring_down", lambda *args: calls.append(1) or real(*args))
    shown = fit.ring_down_plot_data(open_recording(DATA / "example_thread.mmr.h5"), 0, "undamped", 0.1)
    assert len(calls) == 1
    assert shown.model is not None or "refused" in shown.caption
