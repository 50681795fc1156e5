"""A fit of a stored recording, as the task of a job."""

from platform_daemon.estimation import compilation
from platform_daemon.features.fit.fit_request import FitSettings
from platform_daemon.features.fit.work import FitTask


def test_the_phase_of_a_fit_says_that_kernels_are_compiled(measured, monkeypatch):
    phases = []
    task = FitTask(measured / "j.h5", FitSettings(), [0])
    for compiled in (False, True):
        monkeypatch.setattr(compilation, "is_compiled", lambda compiled=compiled: compiled)
        report = task(lambda done, what: phases.append((done, what)))
        assert len(report.good_frames) == 1
    assert phases == [(0.0, compilation.COMPILING), (1.0, "fit"), (0.0, "fit"), (1.0, "fit")]
