"""On-line fits of a series when it ends."""

import threading
from concurrent.futures import Future, ThreadPoolExecutor
from types import SimpleNamespace

from platform_daemon.core.hardware.live_estimate import LiveEstimate
from platform_daemon.features.acquire.series_fits import SeriesFits


class NoTaskIsRun:
    """A task executor that must not be reached."""

    def run(self, *task):
        raise AssertionError(task)


def test_what_waits_without_a_fit_is_cancelled_before_the_shots_are_put_together():
    """Where only the harmonics are wanted and they lag, each would look for the file of a shot that is gone."""
    plan = SimpleNamespace(request=SimpleNamespace(window=None))
    may_go_on = threading.Event()
    with ThreadPoolExecutor(1) as turns:
        turns.submit(may_go_on.wait)
        fits = SeriesFits(plan, turns, NoTaskIsRun(), LiveEstimate(), calibration=None)
        stored: Future = Future()
        for _ in range(3):
            fits.take(SimpleNamespace(identifier="a"), stored, None, blank=False)
        assert fits.outcomes(3) == ["no on-line fit was requested"] * 3
        may_go_on.set()
    assert not stored.done()  # the fits would have waited for it for ever
